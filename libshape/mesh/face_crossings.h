// SPDX-License-Identifier: MIT

#pragma once

#include <array>
#include <vector>

#include "libshape/mesh/points.h"
#include "libshape/mesh/topology.h"

namespace shape::internal {

/// Two faces, the lower first.
using FacePair = std::array<int, 2>;

/// Finds faces of a mesh that pass through each other, in meshes of one topology.
///
/// A tree of bounding boxes is made once, of a reference mesh; for each mesh only its boxes are
/// measured. A face is compared with the 16 of a leaf at once.
class FaceTree
{
public:
    static constexpr int leaf_size = 16; ///< Faces, at most.

    /// Cost: O(#F log #F).
    FaceTree(const Topology& topology, const Points& reference);

    /// All pairs of faces of which a side of one crosses the inside of the other, sorted. Decided
    /// exactly (side_of_plane()): faces that only touch, or lie in one plane, do not cross.
    /// Same result for any number of threads.
    /// Cost: O(#F log #F) for a mesh that bends about as much as the reference does.
    [[nodiscard]] std::vector<FacePair> crossings(const Points& points) const;

private:
    struct Node
    {
        int first, last; ///< Of `order_`.
        int right;       ///< The left child comes next; 0 for a leaf.
    };

    Topology topology_;
    std::vector<int> order_; // of the faces
    std::vector<Node> nodes_;
};

/// The sign of the determinant of (b - a, c - a, d - a): on which side of the plane through a, b and
/// c the point d lies. Exact: where rounding might turn the sign, the determinant is summed up
/// without any (Shewchuk 1997).
/// @param a, b, c, d  Three coordinates each; products of three must not over- or underflow.
[[nodiscard]] int side_of_plane(const double* a, const double* b, const double* c, const double* d);

/// Three coordinates of each corner of a triangle.
using Corners = std::array<const double*, 3>;

/// Whether the side from p to q crosses the inside of a triangle. One from a corner of it, by its address,
/// does not.
[[nodiscard]] bool crosses(const double* p, const double* q, const Corners& t);

} // namespace shape::internal
