// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <vector>

#include "libshape/mesh/points.h"
#include "libshape/mesh/topology.h"

namespace shape {

/// What lengths and dihedral angles say about every face and every pair of neighbours, without any
/// position. The frame of face f has its x axis along half-edge 3 f and z as its outward normal.
struct FaceLayout
{
    /// 3 #F by 3 [length]: row h is half-edge h in the frame of its face; the z column is 0.
    Points halfedges;

    /// #E rotations: the frame of the face right of an edge, seen from that of the face left of it
    /// (left and right of edge_halfedges()(e, 0)); identity on the boundary.
    std::vector<Eigen::Matrix3d> transitions;
};

/// @param lengths  #E [length], > 0. Where they break the triangle inequality the face is laid out
///     flat, as corner_angles() has it.
/// @param dihedral_angles  #E [rad], > 0 convex.
/// @throws InvalidInput if a size is wrong.
/// Cost: O(#F).
[[nodiscard]] FaceLayout lay_out_faces(const Topology& topology, const Eigen::VectorXd& lengths,
                                       const Eigen::VectorXd& dihedral_angles);

/// Cosine of the angle by which the ladybug's walk around every vertex fails to close (Rojas 2014,
/// eq. 1): #V in [-1, 1]; 1 where it closes, and on the boundary. E_v of eq. 2 is 4 (1 - cosine).
/// @param transitions  #E, of a layout.
[[nodiscard]] Eigen::VectorXd closure_cosines(const Topology& topology,
                                              const std::vector<Eigen::Matrix3d>& transitions);

} // namespace shape
