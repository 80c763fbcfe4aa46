// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>

#include "libshape/mesh/points.h"
#include "libshape/mesh/topology.h"

namespace shape {

/// Edge lengths of a mesh, #E [length], >= 0.
/// @throws InvalidInput if points does not have one row per vertex.
[[nodiscard]] Eigen::VectorXd edge_lengths(const Topology& topology, const Points& points);

/// Face angles from edge lengths by the law of cosines, #F by 3 [rad] in [0, pi]; column c is the
/// angle at faces()(f, c). Where the lengths break the triangle inequality the triangle counts as
/// flat: angles 0, 0 and pi.
/// @param lengths  #E [length], > 0.
/// @throws InvalidInput if lengths does not have one entry per edge.
[[nodiscard]] Points corner_angles(const Topology& topology, const Eigen::VectorXd& lengths);

} // namespace shape
