// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <vector>

#include "libshape/mesh/points.h"
#include "libshape/mesh/topology.h"

namespace shape::internal {

/// Unit quaternions: half the memory of matrices.
using Rotations = std::vector<Eigen::Quaterniond>;

/// Axis times angle of a rotation [rad], no longer than pi.
[[nodiscard]] Eigen::Vector3d rotation_vector(const Eigen::Quaterniond& rotation);

/// The rotation about a vector by its length [rad]: the inverse, for any length.
[[nodiscard]] Eigen::Quaterniond rotation_by(const Eigen::Vector3d& vector);

/// How the faces of a mesh lie, #F: x along half-edge 3 f, z the outward normal.
[[nodiscard]] Rotations face_frames(const Topology& topology, const Points& points);

} // namespace shape::internal
