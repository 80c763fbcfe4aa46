// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <vector>

#include "libshape/mesh/points.h"
#include "libshape/mesh/topology.h"

namespace shape::internal {

/// Positions from vertex frames and the half-edges seen in them (Rojas 2014, section 2.2): minimises
///
///     sum over half-edges h from v to u of |v + G_v u_v - u|^2,   u_v = l_h K_h e_x,
///
/// with vertex 0 fixed, then moves the centroid to 0. (Fixing a vertex changes nothing but the
/// translation.)
/// @param lengths  #E [length].
/// @param local_frames  3 #F rotations K_h, of halfedge_frames().
/// @param frames  #V rotations G_v, of vertex_frames().
/// @return #V by 3 [length].
/// @throws InvalidInput if a size is wrong.
/// @throws NumericalError if the normal matrix is not numerically positive definite.
/// Cost: one sparse Cholesky factorisation of size #V - 1.
[[nodiscard]] Points vertex_positions(const Topology& topology, const Eigen::VectorXd& lengths,
                                      const std::vector<Eigen::Matrix3d>& local_frames,
                                      const std::vector<Eigen::Matrix3d>& frames);

} // namespace shape::internal
