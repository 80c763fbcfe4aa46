// SPDX-License-Identifier: MIT

#pragma once

#include <vector>

#include "libshape/mesh/points.h"
#include "libshape/registration/closest_points.h"

namespace shape::internal {

/// The edges of a triangle soup that have one face alone, and the loops they form.
struct Rims
{
    struct Edge
    {
        int from, to; ///< As the face runs through it.
        int opposite; ///< The face's third vertex.
        int loop;
    };
    std::vector<Edge> edges;
    int loop_count = 0; ///< Edges that share a vertex are of one loop.
};

/// Cost: O(#F log #F).
[[nodiscard]] Rims find_rims(const Faces& faces);

/// One loop as a curve that nearest points are looked for on. Its normals point out of the surface,
/// within the surface, so that the two lips of a slit are told apart.
struct RimCurve
{
    std::vector<Rims::Edge> edges;
    Points outward;      ///< One per edge, unit length.
    double length = 0.0; ///< [length]
    ClosestPoints tree;  ///< Face i is edge i: corners from, to, to.

    /// @param loop  In [0, rims.loop_count).
    RimCurve(const Rims& rims, int loop, const Points& points);
};

} // namespace shape::internal
