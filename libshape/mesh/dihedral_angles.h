// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>

#include "libshape/mesh/points.h"
#include "libshape/mesh/topology.h"

namespace shape {

/// Signed bending angle of one hinge [rad] in (-pi, pi]: the edge runs from a to b, vertex c lies on
/// its left and d on its right, seen from outside. 0 is flat, > 0 convex seen from outside; 0 also
/// if a face has no area.
[[nodiscard]] double dihedral_angle(const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                                    const Eigen::Vector3d& c, const Eigen::Vector3d& d);

/// Bending angles of a mesh, #E [rad] in (-pi, pi]; boundary edges 0. An edge of a face without
/// area gets 0.
/// @throws InvalidInput if points does not have one row per vertex.
[[nodiscard]] Eigen::VectorXd dihedral_angles(const Topology& topology, const Points& points);

/// The angle that differs from `angle` by a multiple of 2 pi and lies in (-pi, pi].
[[nodiscard]] double wrapped_angle(double angle);

} // namespace shape
