// SPDX-License-Identifier: MIT

#include "libshape/embedding/energy/region_mesh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "libshape/base/random.h"
#include "libshape/base/to_size.h"
#include "tests/support/meshes.h"

namespace shape {
using namespace internal;
namespace {

/// Up to `count` seeded vertices.
std::vector<int> some_vertices(const Topology& topology, int count, unsigned seed)
{
    Random random(seed);
    std::set<int> vertices;
    for (int i = 0; i < count; ++i)
        vertices.insert(
            static_cast<int>(random.index(static_cast<std::uint64_t>(topology.vertex_count()))));
    return {vertices.begin(), vertices.end()};
}

TEST(RegionMesh, HasTheFacesAndEdgesOfTheMeshUnderLocalNumbers)
{
    for (const test::TestMesh& mesh : test::sample_meshes())
        for (unsigned seed = 1; seed <= 3; ++seed) {
            SCOPED_TRACE(mesh.name);
            const Topology& t = mesh.topology;
            const std::vector<int> moving = some_vertices(t, 5, seed);
            const RegionMesh region(t, moving);
            const auto global = [&](int v) { return region.vertices[to_size(v)]; };

            std::set<int> touched; // faces of the mesh that move
            for (const int v : moving)
                for (const int h : t.outgoing(v))
                    touched.insert(Topology::face(h));
            EXPECT_EQ(region.moving_vertices, static_cast<int>(moving.size()));
            EXPECT_EQ(region.moving_faces, static_cast<int>(touched.size()));
            std::set<int> edges;
            for (const int f : touched)
                for (int c = 0; c < 3; ++c)
                    edges.insert(t.face_edges()(f, c));
            EXPECT_EQ(std::set<int>(region.edges.begin(), region.edges.end()), edges);
            EXPECT_EQ(region.edges.size(), edges.size());

            // Every half-edge beside an edge runs along it, or against it on the other side.
            for (int e = 0; e < region.edge_count(); ++e) {
                const auto at = 2 * to_size(e);
                const int edge = region.edges[to_size(e)];
                EXPECT_EQ(t.find_edge(global(region.ends[at]), global(region.ends[at + 1])), edge);
                const auto source = [&](int h) { return region.corners[to_size(h)]; };
                EXPECT_EQ(source(region.sides[at]), region.ends[at]);
                EXPECT_EQ(source(Topology::next(region.sides[at])), region.ends[at + 1]);
                if (t.is_boundary_edge(edge)) {
                    EXPECT_EQ(region.sides[at + 1], region.sides[at]);
                } else {
                    EXPECT_EQ(source(region.sides[at + 1]), region.ends[at + 1]);
                    EXPECT_EQ(source(Topology::next(region.sides[at + 1])), region.ends[at]);
                }
            }
            for (int h = 0; h < 3 * region.moving_faces; ++h) {
                const int a = region.corners[to_size(h)];
                const int b = region.corners[to_size(Topology::next(h))];
                const auto e = to_size(region.face_edges[to_size(h)]);
                EXPECT_EQ(t.find_edge(global(a), global(b)), region.edges[e]);
            }
        }
}

TEST(RegionMesh, KnowsWhatMeetsAtAVertex)
{
    for (const test::TestMesh& mesh : test::sample_meshes()) {
        SCOPED_TRACE(mesh.name);
        const Topology& t = mesh.topology;
        const RegionMesh region(t, some_vertices(t, 8, 4));
        for (int v = 0; v < region.moving_vertices + region.rim_vertices; ++v) {
            const auto at = to_size(v);
            const int begin = region.halfedge_begins[at];
            const int end = region.halfedge_begins[at + 1];
            EXPECT_EQ(to_size(end - begin), t.outgoing(region.vertices[at]).size());
            for (int i = begin; i < end; ++i)
                EXPECT_EQ(region.corners[to_size(region.halfedges[to_size(i)])], v);
            if (v >= region.moving_vertices)
                continue;
            const int degree = end - begin + (t.is_boundary_vertex(region.vertices[at]) ? 1 : 0);
            EXPECT_EQ(region.edge_begins[at + 1] - region.edge_begins[at], degree);
            for (int i = region.edge_begins[at]; i < region.edge_begins[at + 1]; ++i) {
                const int e = region.incident_edges[to_size(i)];
                EXPECT_EQ(region.ends[to_size(e < 0 ? 2 * ~e : 2 * e + 1)], v);
            }
        }
    }
}

} // namespace
} // namespace shape
