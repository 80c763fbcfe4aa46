// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <span>

#include "libshape/mesh/topology.h"

namespace shape::internal {

/// corner_angles() of some faces alone: row i is that of faces[i], to the same bits.
/// @throws InvalidInput as corner_angles().
[[nodiscard]] Points corner_angles(const Topology& topology, const Eigen::VectorXd& lengths,
                                   std::span<const int> faces);

/// sin(angle / 2) of all corners, #F by 3: in the order of the angles, at a fraction of the cost.
[[nodiscard]] Points corner_half_sines(const Topology& topology, const Eigen::VectorXd& lengths);

} // namespace shape::internal
