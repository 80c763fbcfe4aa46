// SPDX-License-Identifier: MIT

#include "libshape/mesh/topology.h"

#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>
#include <algorithm>
#include <numeric>
#include <vector>

#include "libshape/base/error.h"
#include "libshape/mesh/defects.h"

namespace shape {

namespace {

/// Connectivity only: OpenMesh needs a point type, but no position is ever set.
using Kernel = OpenMesh::TriMesh_ArrayKernelT<>;

Kernel build_kernel(const Faces& faces, int vertex_count)
{
    Kernel kernel;
    kernel.reserve(static_cast<std::size_t>(vertex_count),
                   static_cast<std::size_t>(faces.rows()) * 3 / 2,
                   static_cast<std::size_t>(faces.rows()));
    for (int v = 0; v < vertex_count; ++v)
        kernel.new_vertex();
    for (Eigen::Index f = 0; f < faces.rows(); ++f)
        if (!kernel
                 .add_face(kernel.vertex_handle(static_cast<unsigned>(faces(f, 0))),
                           kernel.vertex_handle(static_cast<unsigned>(faces(f, 1))),
                           kernel.vertex_handle(static_cast<unsigned>(faces(f, 2))))
                 .is_valid())
            throw InvalidInput("face " + std::to_string(f) +
                               " does not fit the half-edge structure of the faces before it");
    return kernel;
}

/// Our half-edge 3 f + c of every half-edge of the kernel, -1 for those outside the surface.
std::vector<int> number_halfedges(const Kernel& kernel, const Faces& faces)
{
    std::vector<int> number(kernel.n_halfedges(), -1);
    for (int f = 0; f < faces.rows(); ++f) {
        auto h = kernel.halfedge_handle(kernel.face_handle(static_cast<unsigned>(f)));
        int corner = 0;
        while (faces(f, corner) != kernel.from_vertex_handle(h).idx())
            ++corner;
        for (int i = 0; i < 3; ++i, h = kernel.next_halfedge_handle(h))
            number[static_cast<std::size_t>(h.idx())] = 3 * f + (corner + i) % 3;
    }
    return number;
}

int count_boundary_loops(const Kernel& kernel)
{
    std::vector<char> seen(kernel.n_halfedges(), 0);
    int loops = 0;
    for (const auto start : kernel.halfedges()) {
        if (!kernel.is_boundary(start) || seen[static_cast<std::size_t>(start.idx())])
            continue;
        ++loops;
        Kernel::HalfedgeHandle h = start;
        do {
            seen[static_cast<std::size_t>(h.idx())] = 1;
            h = kernel.next_halfedge_handle(h);
        } while (h != start);
    }
    return loops;
}

} // namespace

Topology::Topology(const Faces& faces, int vertex_count)
{
    const std::vector<Defect> defects = find_defects(faces, vertex_count, 1);
    if (!defects.empty())
        throw InvalidInput(defects.front().message);

    auto tables = std::make_shared<Tables>();
    tables->vertex_count = vertex_count;
    tables->faces = faces;
    const Kernel kernel = build_kernel(faces, vertex_count);
    const std::vector<int> number = number_halfedges(kernel, faces);
    tables->boundary_loop_count = count_boundary_loops(kernel);

    const auto edge_count = static_cast<int>(kernel.n_edges());
    const auto ends = [&](int e) {
        const auto h = kernel.halfedge_handle(kernel.edge_handle(static_cast<unsigned>(e)), 0);
        return std::minmax({kernel.from_vertex_handle(h).idx(), kernel.to_vertex_handle(h).idx()});
    };
    std::vector<std::pair<std::pair<int, int>, int>> order;
    order.reserve(kernel.n_edges());
    for (int e = 0; e < edge_count; ++e)
        order.emplace_back(ends(e), e);
    std::sort(order.begin(), order.end());

    tables->edges.resize(edge_count, 2);
    tables->edge_halfedges.resize(edge_count, 2);
    tables->face_edges.resize(faces.rows(), 3);
    tables->opposites.assign(static_cast<std::size_t>(3 * faces.rows()), -1);
    for (int e = 0; e < edge_count; ++e) {
        const auto& [vertices, kernel_edge] = order[static_cast<std::size_t>(e)];
        tables->edges.row(e) << vertices.first, vertices.second;
        const auto handle = kernel.edge_handle(static_cast<unsigned>(kernel_edge));
        auto forward = kernel.halfedge_handle(handle, 0);
        if (kernel.from_vertex_handle(forward).idx() != vertices.first)
            forward = kernel.opposite_halfedge_handle(forward);
        int h0 = number[static_cast<std::size_t>(forward.idx())];
        int h1 = number[static_cast<std::size_t>(kernel.opposite_halfedge_handle(forward).idx())];
        if (h0 < 0)
            std::swap(h0, h1);
        tables->edge_halfedges.row(e) << h0, h1;
        tables->face_edges(h0 / 3, h0 % 3) = e;
        tables->opposites[static_cast<std::size_t>(h0)] = h1;
        if (h1 >= 0) {
            tables->face_edges(h1 / 3, h1 % 3) = e;
            tables->opposites[static_cast<std::size_t>(h1)] = h0;
        }
    }

    // First half-edge of every ring: on the boundary if the vertex is, else of the lowest edge.
    std::vector<int> first(static_cast<std::size_t>(vertex_count), -1);
    tables->on_boundary.assign(static_cast<std::size_t>(vertex_count), 0);
    for (int e = 0; e < edge_count; ++e)
        for (int side = 0; side < 2; ++side) {
            const int h = tables->edge_halfedges(e, side);
            if (h < 0)
                continue;
            const auto v = static_cast<std::size_t>(faces(h / 3, h % 3));
            const bool on_boundary = tables->edge_halfedges(e, 1) < 0;
            if (on_boundary) {
                first[v] = h;
                tables->on_boundary[v] = 1;
            } else if (first[v] < 0) {
                first[v] = h;
            }
        }
    tables->ring_begins.reserve(static_cast<std::size_t>(vertex_count) + 1);
    tables->rings.reserve(static_cast<std::size_t>(3 * faces.rows()));
    tables->spoke_begins.reserve(static_cast<std::size_t>(vertex_count) + 1);
    tables->spokes.reserve(2 * static_cast<std::size_t>(tables->edges.rows()));
    const auto corner = [&](const Faces& of_halfedges, int h) {
        return of_halfedges(h / 3, h % 3);
    };
    for (int v = 0; v < vertex_count; ++v) {
        tables->ring_begins.push_back(static_cast<int>(tables->rings.size()));
        tables->spoke_begins.push_back(static_cast<int>(tables->spokes.size()));
        int h = first[static_cast<std::size_t>(v)];
        int in = 0;
        do {
            tables->rings.push_back(h);
            tables->spokes.push_back({h, corner(tables->face_edges, h), corner(faces, next(h))});
            in = previous(h);
            h = tables->opposites[static_cast<std::size_t>(in)];
        } while (h >= 0 && h != first[static_cast<std::size_t>(v)]);
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
