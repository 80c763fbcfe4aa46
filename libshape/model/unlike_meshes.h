// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>

#include "libshape/linalg/dense.h"
#include "libshape/mesh/collection.h"
#include "libshape/model/difference.h"
#include "libshape/model/shape_model.h"

namespace shape::internal {

/// What is known of meshes that new ones are compared with.
struct KnownMeshes
{
    Topology topology;
    Points reference_points;         ///< #V by 3 [length], one of them.
    Eigen::VectorXd dihedral_angles; ///< #E [rad], their mean; or empty.
    double usual_size = 0.0;         ///< [length], their median.
    double least_size = 0.0;         ///< Smaller ones are odd.
    double largest_size = 0.0;       ///< Likewise.
};

/// Odd sizes are more than f times the largest of the model's, or less than an f-th of the smallest: f = 5; of five meshes
/// and more exp(10 s) if that is in [2, 5], or the nearer end, as odd_sizes() has it (s: spread of the logarithms, 1.4826
/// times the median deviation from the median).
[[nodiscard]] KnownMeshes known_meshes(const ShapeModel& model);

/// The same with f = 5 and the mean sizes of both groups; sizes are sums of edge lengths.
[[nodiscard]] KnownMeshes known_meshes(const DifferenceVector& difference);

/// Likewise of the meshes of a collection.
[[nodiscard]] KnownMeshes known_meshes(const Collection& collection);

/// Marks new meshes that are unlike known ones in what edge lengths do not see, or divide out: N by 2, 0 where nothing is
/// odd; then 1 for a mirror image, 2 for one that may as well bend the other way (may_be_bent()), and how many times as large as usual an odd size is.
/// @param meshes  Of the triangulation of the known ones.
/// @param sizes  Theirs, as those of the known ones are measured.
/// Cost: that of is_mirror_image() for each.
[[nodiscard]] RowMatrix unlike_meshes(const KnownMeshes& known, const Collection& meshes,
                                      const Eigen::VectorXd& sizes);

/// How many times as far from the mean of a model as the farthest of its own meshes the given ones are: N, 0 where that is
/// 4 times or less, as of new meshes of other kinds or poses. Exchanged vertices or landmarks are farther.
///
///     sqrt(sum_k t_k^2 + r^2)  against  max over its meshes of sqrt(sum_k t_k^2 + R)
///
/// with scores t, residual r, and the mean R of the squares of what the modes leave of the model's own meshes. Nothing is
/// said beside fewer than five meshes.
/// @param projection  In that model.
[[nodiscard]] Eigen::VectorXd far_meshes(const ShapeModel& model, const Projection& projection);

/// The second of these marks.
[[nodiscard]] double odd_size(const KnownMeshes& known, double size);

} // namespace shape::internal
