// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <memory>
#include <span>
#include <vector>

#include "libshape/mesh/points.h"

namespace shape {

/// The triangulation of a connected oriented manifold, possibly with boundary, of any genus.
///
/// Immutable; copies share their tables. Row e of every per-edge array in the library belongs to
/// `edges().row(e)`; edges are sorted by their lower, then by their higher vertex.
///
/// Half-edge h = 3 f + c runs from faces()(f, c) to faces()(f, (c + 1) % 3); face f lies on its
/// left, seen from outside.
class Topology
{
public:
    /// @throws InvalidInput with the first message of find_defects(), if there is one.
    /// Cost: O(#F log #F). OpenMesh builds the half-edge structure.
    Topology(const Faces& faces, int vertex_count);

    [[nodiscard]] int vertex_count() const { return tables_->vertex_count; }
    [[nodiscard]] int edge_count() const { return static_cast<int>(edges().rows()); }
    [[nodiscard]] int face_count() const { return static_cast<int>(faces().rows()); }

    [[nodiscard]] const Faces& faces() const { return tables_->faces; } ///< #F by 3.

    /// #E by 2, lower index first, sorted.
    [[nodiscard]] const Edges& edges() const { return tables_->edges; }

    /// #F by 3; column c is the edge of half-edge 3 f + c.
    [[nodiscard]] const Faces& face_edges() const { return tables_->face_edges; }

    /// #E by 2 half-edges. Column 0 is present always, column 1 is -1 on the boundary. Where both
    /// are present, column 0 runs from edges()(e, 0) to edges()(e, 1), column 1 back.
    [[nodiscard]] const Edges& edge_halfedges() const { return tables_->edge_halfedges; }

    [[nodiscard]] int halfedge_count() const { return 3 * face_count(); }
    [[nodiscard]] int source(int halfedge) const { return faces()(halfedge / 3, halfedge % 3); }
    [[nodiscard]] int target(int halfedge) const { return source(next(halfedge)); }
    [[nodiscard]] int edge(int halfedge) const { return face_edges()(halfedge / 3, halfedge % 3); }

    /// -1 on the boundary.
    [[nodiscard]] int opposite(int halfedge) const { return tables_->opposites[index(halfedge)]; }

    /// Of all half-edges.
    [[nodiscard]] std::span<const int> opposites() const { return tables_->opposites; }

    [[nodiscard]] static int face(int halfedge) { return halfedge / 3; }
    [[nodiscard]] static int next(int h) { return h % 3 == 2 ? h - 2 : h + 1; }
    [[nodiscard]] static int previous(int h) { return h % 3 == 0 ? h + 2 : h - 1; }

    /// Half-edges that leave a vertex, counter-clockwise seen from outside. At an interior vertex
    /// the first is that of the edge with the lowest index; at a boundary vertex the first runs
    /// along the boundary, so that the faces left of them are the whole fan.
    [[nodiscard]] std::span<const int> outgoing(int vertex) const
    {
        const std::vector<int>& begins = tables_->ring_begins;
        return {tables_->rings.data() + begins[index(vertex)],
                tables_->rings.data() + begins[index(vertex) + 1]};
    }

    /// An edge seen from one of its ends.
    struct Spoke
    {
        int halfedge; ///< Away from that end; -1 where there is none.
        int edge;
        int vertex; ///< Its other end.
    };
    /// All edges at a vertex in the order of outgoing(); at a boundary vertex the last one is that
    /// which has only a half-edge that comes in.
    [[nodiscard]] std::span<const Spoke> spokes(int vertex) const
    {
        const std::vector<int>& begins = tables_->spoke_begins;
        return {tables_->spokes.data() + begins[index(vertex)],
                tables_->spokes.data() + begins[index(vertex) + 1]};
    }

    [[nodiscard]] bool is_boundary_vertex(int vertex) const
    {
        return tables_->on_boundary[index(vertex)] != 0;
    }
    [[nodiscard]] bool is_boundary_edge(int edge) const { return edge_halfedges()(edge, 1) < 0; }
    [[nodiscard]] bool is_closed() const { return boundary_loop_count() == 0; }
    [[nodiscard]] int boundary_loop_count() const { return tables_->boundary_loop_count; }
    [[nodiscard]] int euler_characteristic() const; ///< #V - #E + #F.
    [[nodiscard]] int genus() const;                ///< Handles once every boundary loop is filled.

    /// Edge between two vertices, -1 if there is none. Cost: O(log #E).
    [[nodiscard]] int find_edge(int a, int b) const;

    /// Same vertex count and same face array.
    [[nodiscard]] bool operator==(const Topology& other) const;

private:
    struct Tables
    {
        int vertex_count = 0;
        Faces faces;
        Edges edges;
        Faces face_edges;
        Edges edge_halfedges;
        std::vector<int> opposites;    // per half-edge
        std::vector<int> ring_begins;  // per vertex + 1, into rings
        std::vector<int> rings;        // half-edges, see outgoing()
        std::vector<int> spoke_begins; // per vertex + 1, into spokes
        std::vector<Spoke> spokes;
        std::vector<char> on_boundary; // per vertex
        int boundary_loop_count = 0;
    };
    static std::size_t index(int i) { return static_cast<std::size_t>(i); }

    std::shared_ptr<const Tables> tables_;
};

} // namespace shape
