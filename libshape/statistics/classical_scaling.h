// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>

#include "libshape/linalg/dense.h"

namespace shape {

/// Points whose Euclidean distances are near given ones.
struct ClassicalScaling
{
    RowMatrix points;            ///< N by K, columns of sum 0, orthogonal, longest first.
    Eigen::VectorXd eigenvalues; ///< K, descending: squared lengths of the columns where > 0.
    double total = 0.0;          ///< Sum of all squared lengths: trace of the centred matrix.
};

/// Classical (metric) scaling (Torgerson 1952, Gower 1966): the leading eigenvectors of the centred
/// matrix B = -1/2 J D^2 J, times the roots of their eigenvalues; 0 where one is not positive.
/// Distances of points in K dimensions are given back; of others, the points are the orthogonal
/// projection on the first K principal components.
/// The sign of a column makes its entry of largest magnitude positive (the first of those equal
/// within 1e-9 of it).
///
/// @param distances  N by N, see check_distances().
/// @param dimensions  K in [1, N].
/// @throws InvalidInput if a rule above is broken.
[[nodiscard]] ClassicalScaling classical_scaling(const Eigen::MatrixXd& distances,
                                                 int dimensions = 2);

} // namespace shape
