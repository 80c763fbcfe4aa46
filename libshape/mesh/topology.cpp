// SPDX-License-Identifier: MIT

#include "libshape/mesh/topology.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "libshape/base/error.h"
#include "libshape/base/to_size.h"
#include "libshape/mesh/defects.h"
#include "libshape/mesh/half_edges.h"

namespace shape {
using namespace internal;

Topology::Topology(const Faces& faces, int vertex_count)
{
    const std::vector<Defect> defects = find_defects(faces, vertex_count, 1);
    if (!defects.empty())
        throw InvalidInput(defects.front().message);

    auto tables = std::make_shared<Tables>();
    tables->vertex_count = vertex_count;
    tables->faces = faces;
    HalfEdges pairs = half_edges(faces, vertex_count);
    tables->boundary_loop_count = pairs.boundary_loop_count;
    tables->edges = std::move(pairs.edges);
    tables->edge_halfedges = std::move(pairs.sides);
    tables->face_edges.resize(faces.rows(), 3);
    tables->opposites.assign(to_size(3 * faces.rows()), -1);
    for (int e = 0; e < tables->edges.rows(); ++e) {
        const int h0 = tables->edge_halfedges(e, 0);
        const int h1 = tables->edge_halfedges(e, 1);
        tables->face_edges(h0 / 3, h0 % 3) = e;
        tables->opposites[to_size(h0)] = h1;
        if (h1 >= 0) {
            tables->face_edges(h1 / 3, h1 % 3) = e;
            tables->opposites[to_size(h1)] = h0;
        }
    }

    // First half-edge of every ring: on the boundary if the vertex is, else of the lowest edge.
    std::vector<int> first(to_size(vertex_count), -1);
    tables->on_boundary.assign(to_size(vertex_count), 0);
    for (int e = 0; e < tables->edges.rows(); ++e)
        for (int side = 0; side < 2; ++side) {
            const int h = tables->edge_halfedges(e, side);
            if (h < 0)
                continue;
            const auto v = to_size(faces(h / 3, h % 3));
            const bool on_boundary = tables->edge_halfedges(e, 1) < 0;
            if (on_boundary) {
                first[v] = h;
                tables->on_boundary[v] = 1;
            } else if (first[v] < 0) {
                first[v] = h;
            }
        }
    tables->ring_begins.reserve(to_size(vertex_count) + 1);
    tables->rings.reserve(to_size(3 * faces.rows()));
    tables->spoke_begins.reserve(to_size(vertex_count) + 1);
    tables->spokes.reserve(2 * to_size(tables->edges.rows()));
    const auto corner = [&](const Faces& of_halfedges, int h) {
        return of_halfedges(h / 3, h % 3);
    };
    for (int v = 0; v < vertex_count; ++v) {
        tables->ring_begins.push_back(static_cast<int>(tables->rings.size()));
        tables->spoke_begins.push_back(static_cast<int>(tables->spokes.size()));
        int h = first[to_size(v)];
        int in = 0;
        do {
            tables->rings.push_back(h);
            tables->spokes.push_back({h, corner(tables->face_edges, h), corner(faces, next(h))});
            in = previous(h);
            h = tables->opposites[to_size(in)];
        } while (h >= 0 && h != first[to_size(v)]);
        if (h < 0)
            tables->spokes.push_back({-1, corner(tables->face_edges, in), corner(faces, in)});
    }
    tables->ring_begins.push_back(static_cast<int>(tables->rings.size()));
    tables->spoke_begins.push_back(static_cast<int>(tables->spokes.size()));
    tables_ = std::move(tables);
}

int Topology::euler_characteristic() const
{
    return vertex_count() - edge_count() + face_count();
}

int Topology::genus() const
{
    return (2 - boundary_loop_count() - euler_characteristic()) / 2;
}

int Topology::find_edge(int a, int b) const
{
    const std::pair<int, int> key = std::minmax(a, b);
    int low = 0;
    int high = edge_count();
    while (low < high) {
        const int middle = (low + high) / 2;
        if (std::pair(edges()(middle, 0), edges()(middle, 1)) < key)
            low = middle + 1;
        else
            high = middle;
    }
    const bool found =
        low < edge_count() && edges()(low, 0) == key.first && edges()(low, 1) == key.second;
    return found ? low : -1;
}

bool Topology::operator==(const Topology& other) const
{
    return tables_ == other.tables_ ||
           (vertex_count() == other.vertex_count() && face_count() == other.face_count() &&
            faces() == other.faces());
}

} // namespace shape
