// SPDX-License-Identifier: MIT

#pragma once

#include "libshape/mesh/points.h"

namespace shape::internal {

/// The edges of a triangulation, sorted, and what runs along them.
struct HalfEdges
{
    Edges edges; ///< #E by 2, lower index first, sorted.
    Edges
        sides; ///< #E by 2: half-edges 3 f + c along the edge and against it; the one there is and
               ///< -1 on the boundary.
    int boundary_loop_count = 0;
};

/// @param faces  Without defects (defects.h).
/// Cost: O(#F log #F). OpenMesh builds the half-edge structure.
[[nodiscard]] HalfEdges half_edges(const Faces& faces, int vertex_count);

} // namespace shape::internal
