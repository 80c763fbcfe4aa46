// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>

#include "libshape/edge_space/shape_space.h"
#include "libshape/mesh/collection.h"

namespace shape {

/// Distances between all meshes of a collection, and the space that they were measured in.
struct ShapeDistances
{
    ShapeSpace space;
    Eigen::MatrixXd matrix; ///< N by N, symmetric, 0 on the diagonal.
};

/// In edge space: Euclidean distances of the coordinates, in their unit. In Procrustes space: the
/// root of the mean squared distance of corresponding vertices after generalised alignment [length],
/// for Scale::Unit with every mesh at the mean centroid size.
/// @throws InvalidInput if there are fewer than 2 meshes, or make_space() refuses its options.
[[nodiscard]] ShapeDistances shape_distances(const Collection& collection,
                                             const SpaceOptions& options);

} // namespace shape
