// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "libshape/edge_space/shape_vectors.h"
#include "libshape/mesh/topology.h"

namespace shape {

// Constrained interpolation (Winkler 2010, section 3.2 and Fig. 12): wanted lengths of a chosen part
// are multiplied by a factor before the embedding.

/// How much each edge belongs to the tagged part, #E in [0, 1]: the mean of its ends, where a vertex
/// d edges away from the nearest tagged one counts max(0, 1 - d / rings). (Multiplying edges with both
/// ends in the part alone would break every near-equilateral triangle across the border at a factor
/// of 2; with the mean no equilateral triangle ever breaks.)
/// @param vertices  Indices, in any order.
/// @param rings  Over which the part fades out, >= 1.
/// @throws InvalidInput if an index or `rings` is out of range.
[[nodiscard]] Eigen::VectorXd tagged_shares(const Topology& topology, std::span<const int> vertices,
                                            int rings = 1);

/// The corners of faces.
/// @throws InvalidInput if an index is out of range.
[[nodiscard]] std::vector<int> corners_of_faces(const Topology& topology,
                                                std::span<const int> faces);

/// The point with its lengths multiplied by 1 + share (factor - 1); angles stay as they are.
/// @param shares  #E in [0, 1].
/// @param factor  > 0.
/// @throws InvalidInput if a size does not fit or the factor is out of its range.
[[nodiscard]] ShapePoint scale_tagged(ShapePoint point, const Eigen::VectorXd& shares,
                                      double factor);

} // namespace shape
