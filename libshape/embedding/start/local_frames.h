// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <vector>

#include "libshape/mesh/points.h"
#include "libshape/mesh/topology.h"

namespace shape::internal {

/// The orthonormal frame of vertex v (Rojas 2014, section 2.2) has its x axis along
/// outgoing(v)[0], its y axis in the face left of it and z as the outward normal of that face.
/// All matrices below are rotations whose columns are axes.

/// Axes carried by the ladybug around each vertex (Rojas 2014, Fig. 2): entry h, in the frame of
/// source(h), has x along half-edge h and z along the normal of the face left of it. With corner
/// angles c and bending angles d,
///
///     K_h0 = I,   K_h(i+1) = K_hi Z(c_hi) X(-d_h(i+1)).
///
/// @param corner_angles  #F by 3 [rad].
/// @param dihedral_angles  #E [rad], > 0 convex; boundary edges are ignored.
/// @return 3 #F rotations.
/// @throws InvalidInput if a size is wrong.
/// Cost: O(#F).
[[nodiscard]] std::vector<Eigen::Matrix3d> halfedge_frames(const Topology& topology,
                                                           const Points& corner_angles,
                                                           const Eigen::VectorXd& dihedral_angles);

/// The matrix M_vu of every edge that takes coordinates in the frame of u to those in the frame of
/// v (Rojas 2014, section 2.2), where edge e runs from v to u as edge_halfedges()(e, 0) does. It
/// passes through the face left of that half-edge: M_vu = K_h Z(pi - c) K_next(h)^T with the corner
/// angle c at u.
/// @param frames  Of halfedge_frames().
/// @return #E rotations.
/// @throws InvalidInput if a size is wrong.
[[nodiscard]] std::vector<Eigen::Matrix3d> frame_transitions(
    const Topology& topology, const Points& corner_angles,
    const std::vector<Eigen::Matrix3d>& frames);

/// Rotation about the x axis, right-handed; angle [rad].
[[nodiscard]] Eigen::Matrix3d turn_about_x(double angle);

/// Rotation about the z axis, right-handed; angle [rad].
[[nodiscard]] Eigen::Matrix3d turn_about_z(double angle);

} // namespace shape::internal
