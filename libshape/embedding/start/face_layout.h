// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "libshape/mesh/rotations.h"
#include "libshape/mesh/topology.h"

namespace shape::internal {

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

/// frame * transition, or frame * transition^-1. Without the branch, which no processor foresees.
[[nodiscard]] inline Eigen::Quaterniond followed_by(const Eigen::Quaterniond& frame,
                                                    const Eigen::Quaterniond& transition,
                                                    bool forward)
{
    const double way = 2.0 * forward - 1.0;
    const double w = transition.w();
    const double x = way * transition.x();
    const double y = way * transition.y();
    const double z = way * transition.z();
    return {frame.w() * w - frame.x() * x - frame.y() * y - frame.z() * z,
            frame.w() * x + frame.x() * w + frame.y() * z - frame.z() * y,
            frame.w() * y + frame.y() * w + frame.z() * x - frame.x() * z,
            frame.w() * z + frame.z() * w + frame.x() * y - frame.y() * x};
}

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

} // namespace shape::internal
