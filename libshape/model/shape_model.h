// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "libshape/edge_space/shape_space.h"
#include "libshape/linalg/dense.h"
#include "libshape/mesh/collection.h"

namespace shape {

/// Mean and principal modes of a collection in a space of shapes, in edge space with companion
/// dihedral parts, and the scores of the meshes it was made from.
struct ShapeModel
{
    Topology topology;
    Points reference_points; ///< #V by 3 [length]; the first mesh of the collection.
    ShapeSpace space;
    Eigen::VectorXd mean;                 ///< D coordinates of the space.
    Eigen::VectorXd mean_dihedral_angles; ///< #E [rad]; empty if the space needs no companions.
    RowMatrix modes;                      ///< K by D, orthonormal rows.
    RowMatrix mode_dihedral_angles;       ///< K by #E [rad per unit of score], or K by 0.
    Eigen::VectorXd variances;            ///< K, descending, divisor N - 1.
    double total_variance = 0.0;          ///< The sum over all modes, kept or not.
    RowMatrix scores;                     ///< N by K, coordinates along the modes.
    Eigen::VectorXd sizes;                ///< N, see sizes() of shape_space.h [length].
    std::vector<std::string> names;       ///< N.
    Labels labels;

    [[nodiscard]] int mode_count() const { return static_cast<int>(variances.size()); }
    [[nodiscard]] double mean_size() const { return sizes.mean(); }
};

struct ModelOptions
{
    /// This many modes are kept, K in [1, N - 1]; 0: as few as have the share `variance`.
    int modes = 0;
    /// The modes kept have at least this share of the total variance; in (0, 1], and 1 unless `modes`
    /// is 0.
    double variance = 1.0;
    /// The model is made in this space.
    SpaceOptions space = {};
};

/// @throws InvalidInput naming the first field that breaks its rule.
void check(const ModelOptions& options);

/// Fits a model: PCA of the coordinates through the N by N Gram matrix; never a D by D one.
/// The sign of a mode makes its coordinate of largest magnitude positive (the first of equals).
/// Modes that are rounding (variance below 1e-12 times the largest) are left out.
/// Memory: beside the collection and the model, one N by D matrix.
/// @throws InvalidInput if the collection has fewer than 2 meshes, modes is not in [0, N - 1],
///     variance is not in (0, 1], all meshes are equal, or make_space() refuses its options.
[[nodiscard]] ShapeModel fit_model(const Collection& collection, const ModelOptions& options = {});

/// The point mean + sum_k scores[k] mode_k, decoded: in units of length.
/// @param scores  At most K coordinates along the modes (not in standard deviations); missing ones are 0.
/// @param size  As decode() takes it. The default of the program is mean_size().
/// @throws InvalidInput if there are more scores than modes, one is not finite, or size <= 0.
[[nodiscard]] DecodedShape model_point(const ShapeModel& model, const Eigen::VectorXd& scores,
                                       double size);

/// Scores of meshes, new or old, in a model.
struct Projection
{
    std::vector<std::string> names;
    Labels labels;
    RowMatrix scores;          ///< N by K.
    Eigen::VectorXd sizes;     ///< N [length].
    Eigen::VectorXd residuals; ///< N distances to the span of the modes, in the model's units.
};

/// @throws InvalidInput if the collection has another triangulation.
[[nodiscard]] Projection project(const ShapeModel& model, const Collection& collection);

/// How far one can go along a mode from the mean before a triangle inequality breaks; everywhere in
/// Procrustes space.
struct FeasibleRange
{
    double low = 0.0;  ///< Standard deviations, in [-limit, 0].
    double high = 0.0; ///< Standard deviations, in [0, limit].
};

/// @param mode  Index in [0, K).
/// @param limit  Where the search ends, in standard deviations; > 0.
/// @throws InvalidInput if mode or limit is out of its range.
[[nodiscard]] FeasibleRange feasible_range(const ShapeModel& model, int mode, double limit = 10.0);

} // namespace shape
