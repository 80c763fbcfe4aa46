// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <vector>

#include "libshape/mesh/topology.h"

namespace shape {

/// Unit quaternions: half the memory of matrices.
using Rotations = std::vector<Eigen::Quaterniond>;

/// What lengths and dihedral angles say about every face and every pair of neighbours, without any
/// position. The frame of face f has its x axis along half-edge 3 f and z as its outward normal.
struct FaceLayout
{
    /// 4 by #F [length]: in column f the x of the three half-edges of a face, and the y of the
    /// second, >= 0. That of the first is 0, that of the third the opposite.
    Eigen::Matrix4Xd sides;

    /// #E: the frame of the face right of an edge, seen from that of the face left of it
    /// (left and right of edge_halfedges()(e, 0)); identity on the boundary.
    Rotations transitions;

    /// A half-edge in the plane of its face, from corner c.
    [[nodiscard]] Eigen::Vector2d halfedge(int face, int c) const
    {
        constexpr double signs[] = {0.0, 1.0, -1.0};
        const double* const side = sides.data() + 4 * face;
        return {side[c], signs[c] * side[3]};
    }
    [[nodiscard]] Eigen::Vector2d halfedge(int h) const { return halfedge(h / 3, h % 3); }
};

/// @param lengths  #E [length], > 0. Where they break the triangle inequality the face is laid out
///     flat, as corner_angles() has it.
/// @param dihedral_angles  #E [rad], > 0 convex.
/// @param memory  A layout no longer needed, whose memory serves again.
/// @throws InvalidInput if a size is wrong.
/// Cost: O(#F).
[[nodiscard]] FaceLayout lay_out_faces(const Topology& topology, const Eigen::VectorXd& lengths,
                                       const Eigen::VectorXd& dihedral_angles,
                                       FaceLayout memory = {});

/// Angle by which the ladybug's walk around every vertex fails to close (Rojas 2014, eq. 1):
/// #V in [0, pi] [rad]; 0 where it closes, and on the boundary. E_v of eq. 2 is 4 (1 - cosine).
/// @param transitions  #E, of a layout.
[[nodiscard]] Eigen::VectorXd closure_angles(const Topology& topology,
                                             const Rotations& transitions);

} // namespace shape
