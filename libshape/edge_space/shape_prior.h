// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <vector>

#include "libshape/edge_space/shape_vectors.h"
#include "libshape/linalg/dense.h"

namespace shape {

/// What is expected of a shape before it is seen: lengths s (m + sum_k z_k a_k + noise), where the scores z_k are
/// independent and standard normal, the noise is of variance `noise` in every direction, and any size s is
/// as good as another. Dihedral angles follow the same scores.
struct ShapePrior
{
    ShapePoint mean;        ///< m; lengths in any unit, as it is for all of these.
    RowMatrix length_steps; ///< a: K by #E, one standard deviation a row; need not be orthogonal.
    RowMatrix angle_steps;  ///< K by #E [rad].
    double noise = 0.0;     ///< [unit^2], > 0.
};

/// The most likely shape of a prior, given lengths of some of its edges.
struct ShapePosterior
{
    Eigen::VectorXd scores; ///< z: K, in standard deviations.
    double size = 1.0;      ///< s > 0.
    ShapePoint point; ///< s (m + sum z a): all edges, those that were not seen too; lengths > 0.
    double residual = 0.0; ///< RMS of the lengths seen that it leaves, over the mean length.
};

/// Least squares with z held to 0 by their variance, size and scores in turn.
/// @param lengths  #E [length], > 0.
/// @param seen  #E: the edges that count; at least one.
/// @throws InvalidInput if sizes disagree, the noise is not > 0, or no edge is seen.
/// Cost: O(#E K^2 + K^3).
[[nodiscard]] ShapePosterior posterior(const ShapePrior& prior, const Eigen::VectorXd& lengths,
                                       const std::vector<char>& seen);

/// The prior that N shapes are of a further one: their mean, and deviations from it over sqrt(N - 1).
/// @param vectors  Rows of unit sum; N >= 2 without the one left out.
/// @param without  A row that is left out, in [-1, N); -1: none.
/// @throws InvalidInput if there are fewer rows, no such row, or the noise is not > 0.
[[nodiscard]] ShapePrior prior_of(const ShapeVectors& vectors, int without, double noise);

} // namespace shape
