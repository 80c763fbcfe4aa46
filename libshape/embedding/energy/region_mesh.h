// SPDX-License-Identifier: MIT

#pragma once

#include <vector>

#include "libshape/mesh/topology.h"

namespace shape::internal {

/// Added to a squared length or area, in units of mean lengths, so that no eight lanes divide 0 by 0.
inline constexpr float least_square = 1e-18F;

/// A part of a mesh in numbers of its own: some vertices that move, and what their faces and hinges
/// are made of. Local vertices are those that move, then the rim (the other vertices of their
/// faces), then the rest of the rim's faces.
struct RegionMesh
{
    int moving_vertices = 0;
    int rim_vertices = 0;
    int moving_faces = 0;      ///< These come first; they have a vertex that moves.
    std::vector<int> vertices; ///< The vertex of the mesh that every local one is.
    std::vector<int> corners; ///< Three local vertices a face, from the same one on as in the mesh.

    std::vector<int> edges; ///< The edges of the mesh that belong to moving faces.
    std::vector<int> ends;  ///< Two local vertices an edge.
    /// Two half-edges 3 f + c an edge, the first along the edge; on the boundary the first twice.
    std::vector<int> sides;
    std::vector<int> face_edges; ///< Three local edges a moving face.

    /// Of vertices that move or lie on the rim: leaving half-edges h of local faces, from
    /// halfedge_begins[v] on.
    std::vector<int> halfedge_begins, halfedges;
    /// Of vertices that move: edges e that end there, or ~e if they start there.
    std::vector<int> edge_begins, incident_edges;

    /// @param moving  Distinct vertices, not empty.
    RegionMesh(const Topology& topology, const std::vector<int>& moving);

    [[nodiscard]] int vertex_count() const { return static_cast<int>(vertices.size()); }
    [[nodiscard]] int face_count() const { return static_cast<int>(corners.size()) / 3; }
    [[nodiscard]] int edge_count() const { return static_cast<int>(edges.size()); }
};

} // namespace shape::internal
