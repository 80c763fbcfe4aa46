// SPDX-License-Identifier: MIT

#include "libshape/mesh/half_edges.h"

#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>
#include <algorithm>
#include <string>
#include <vector>

#include "libshape/base/error.h"
#include "libshape/base/to_size.h"

namespace shape::internal {
namespace {

/// Connectivity only: OpenMesh needs a point type, but no position is ever set.
using Kernel = OpenMesh::TriMesh_ArrayKernelT<>;

Kernel build_kernel(const Faces& faces, int vertex_count)
{
    Kernel kernel;
    kernel.reserve(to_size(vertex_count), to_size(faces.rows()) * 3 / 2, to_size(faces.rows()));
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

/// The half-edge 3 f + c (mesh/topology.h) of every half-edge of the kernel, -1 for those outside the surface.
std::vector<int> number_halfedges(const Kernel& kernel, const Faces& faces)
{
    std::vector<int> number(kernel.n_halfedges(), -1);
    for (int f = 0; f < faces.rows(); ++f) {
        auto h = kernel.halfedge_handle(kernel.face_handle(static_cast<unsigned>(f)));
        int corner = 0;
        while (faces(f, corner) != kernel.from_vertex_handle(h).idx())
            ++corner;
        for (int i = 0; i < 3; ++i, h = kernel.next_halfedge_handle(h))
            number[to_size(h.idx())] = 3 * f + (corner + i) % 3;
    }
    return number;
}

int count_boundary_loops(const Kernel& kernel)
{
    std::vector<char> seen(kernel.n_halfedges(), 0);
    int loops = 0;
    for (const auto start : kernel.halfedges()) {
        if (!kernel.is_boundary(start) || seen[to_size(start.idx())])
            continue;
        ++loops;
        Kernel::HalfedgeHandle h = start;
        do {
            seen[to_size(h.idx())] = 1;
            h = kernel.next_halfedge_handle(h);
        } while (h != start);
    }
    return loops;
}

} // namespace

HalfEdges half_edges(const Faces& faces, int vertex_count)
{
    const Kernel kernel = build_kernel(faces, vertex_count);
    const std::vector<int> number = number_halfedges(kernel, faces);
    HalfEdges result;
    result.boundary_loop_count = count_boundary_loops(kernel);

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

    result.edges.resize(edge_count, 2);
    result.sides.resize(edge_count, 2);
    for (int e = 0; e < edge_count; ++e) {
        const auto& [vertices, kernel_edge] = order[to_size(e)];
        result.edges.row(e) << vertices.first, vertices.second;
        const auto handle = kernel.edge_handle(static_cast<unsigned>(kernel_edge));
        auto forward = kernel.halfedge_handle(handle, 0);
        if (kernel.from_vertex_handle(forward).idx() != vertices.first)
            forward = kernel.opposite_halfedge_handle(forward);
        int h0 = number[to_size(forward.idx())];
        int h1 = number[to_size(kernel.opposite_halfedge_handle(forward).idx())];
        if (h0 < 0)
            std::swap(h0, h1);
        result.sides.row(e) << h0, h1;
    }
    return result;
}

} // namespace shape::internal
