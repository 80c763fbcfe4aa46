// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <vector>

#include "libshape/mesh/topology.h"

namespace shape::internal {

/// Orientation of every vertex frame in one global frame (Rojas 2014, section 2.2): minimises
///
///     sum over edges (v, u) of |G_v M_vu - G_u|^2,   G_0 = I,
///
/// over matrices, then replaces each G_v by the nearest rotation.
/// @param transitions  #E rotations M_vu, of frame_transitions().
/// @return #V rotations, determinant +1.
/// @throws InvalidInput if transitions has another size.
/// @throws NumericalError if the normal matrix is not numerically positive definite.
/// Cost: one sparse Cholesky factorisation of size 3 #V - 3.
[[nodiscard]] std::vector<Eigen::Matrix3d> vertex_frames(
    const Topology& topology, const std::vector<Eigen::Matrix3d>& transitions);

} // namespace shape::internal
