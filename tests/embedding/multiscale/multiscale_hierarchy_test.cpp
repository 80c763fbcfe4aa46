// SPDX-License-Identifier: MIT

#include "libshape/embedding/multiscale/multiscale_hierarchy.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <numeric>
#include <set>

#include "libshape/base/error.h"
#include "libshape/base/threads.h"
#include "libshape/base/to_size.h"
#include "tests/embedding/multiscale/multiscale_meshes.h"

namespace shape {
using namespace internal;
namespace {

template <class Value>
std::span<const Value> part(const std::vector<Value>& values, Slice slice)
{
    return std::span(values).subspan(slice.begin, to_size(slice.count));
}

std::set<int> as_set(std::span<const int> values)
{
    return {values.begin(), values.end()};
}

std::span<const PatchNode> children(const MultiscaleHierarchy& h, const PatchNode& node)
{
    return std::span(h.nodes).subspan(to_size(node.first_child), to_size(node.child_count));
}

/// Number of faces reached from the first across edges of the patch.
std::size_t reached_faces(const Topology& topology, const std::set<int>& faces)
{
    std::set<int> reached{*faces.begin()};
    std::vector<int> queue{*faces.begin()};
    for (std::size_t i = 0; i < queue.size(); ++i)
        for (int c = 0; c < 3; ++c) {
            const int opposite = topology.opposite(3 * queue[i] + c);
            if (opposite >= 0 && faces.count(Topology::face(opposite)) != 0 &&
                reached.insert(Topology::face(opposite)).second)
                queue.push_back(Topology::face(opposite));
        }
    return reached.size();
}

TEST(MultiscaleHierarchy, RootIsTheWholeMesh)
{
    for (const test::TestMesh& mesh : test::multiscale_meshes()) {
        SCOPED_TRACE(mesh.name);
        const MultiscaleHierarchy h = build_hierarchy(mesh.topology, mesh.points);
        const auto counts = [](std::set<int> set, int size) {
            return static_cast<int>(set.size()) == size && *set.begin() == 0 &&
                   *set.rbegin() == size - 1;
        };
        EXPECT_EQ(h.nodes[0].parent, -1);
        EXPECT_EQ(h.nodes[0].faces.count, mesh.topology.face_count());
        EXPECT_EQ(h.nodes[0].vertices.count, mesh.topology.vertex_count());
        EXPECT_EQ(h.nodes[0].edges.count, mesh.topology.edge_count());
        EXPECT_TRUE(counts(as_set(part(h.faces, h.nodes[0].faces)), mesh.topology.face_count()));
        EXPECT_TRUE(
            counts(as_set(part(h.vertices, h.nodes[0].vertices)), mesh.topology.vertex_count()));
    }
}

TEST(MultiscaleHierarchy, ChildrenAreSmallerConnectedAndCoverTheirParent)
{
    for (const test::TestMesh& mesh : test::multiscale_meshes()) {
        SCOPED_TRACE(mesh.name);
        const MultiscaleHierarchy h = build_hierarchy(mesh.topology, mesh.points);
        for (std::size_t i = 0; i < h.nodes.size(); ++i) {
            const PatchNode& node = h.nodes[i];
            EXPECT_EQ(reached_faces(mesh.topology, as_set(part(h.faces, node.faces))),
                      to_size(node.faces.count));
            if (node.is_leaf()) {
                EXPECT_LT(node.faces.count, 6);
                continue;
            }
            ASSERT_GT(node.first_child, static_cast<int>(i));
            std::set<int> covered;
            for (const PatchNode& child : children(h, node)) {
                EXPECT_EQ(child.parent, static_cast<int>(i));
                EXPECT_LT(child.faces.count, node.faces.count);
                covered.merge(as_set(part(h.faces, child.faces)));
            }
            EXPECT_EQ(covered, as_set(part(h.faces, node.faces)));
        }
    }
}

TEST(MultiscaleHierarchy, ChildrenOverlapInStripsOfOneTriangle)
{
    for (const test::TestMesh& mesh : test::multiscale_meshes()) {
        SCOPED_TRACE(mesh.name);
        const Topology& t = mesh.topology;
        const MultiscaleHierarchy h = build_hierarchy(t, mesh.points);
        for (const PatchNode& node : h.nodes) {
            if (node.is_leaf())
                continue;
            // Both triangles of every inner edge are together in a child; a child has a triangle
            // beyond its core only because of such an edge, and each edge gives it to one child.
            std::map<int, std::set<int>> owners;
            std::size_t copies = 0;
            for (int k = 0; k < node.child_count; ++k)
                for (const int f : part(h.faces, children(h, node)[to_size(k)].faces)) {
                    owners[f].insert(k);
                    ++copies;
                }
            std::size_t seams = 0;
            for (const PatchEdge& edge : part(h.edges, node.edges)) {
                const int a = t.edge_halfedges()(edge.edge, 0);
                const int b = t.edge_halfedges()(edge.edge, 1);
                if (b < 0 || owners.count(Topology::face(a)) == 0 ||
                    owners.count(Topology::face(b)) == 0)
                    continue;
                const std::set<int>& left = owners[Topology::face(a)];
                const std::set<int>& right = owners[Topology::face(b)];
                std::vector<int> both;
                std::set_intersection(left.begin(), left.end(), right.begin(), right.end(),
                                      std::back_inserter(both));
                EXPECT_FALSE(both.empty());
                seams += left.size() > 1 || right.size() > 1 ? 1 : 0;
            }
            EXPECT_LE(copies - to_size(node.faces.count), seams);
            for (const auto& [face, set] : owners)
                EXPECT_LE(set.size(), 4U); // its core and one for each edge
        }
    }
}

TEST(MultiscaleHierarchy, RowsOfVerticesAndEdgesAgreeWithTheMesh)
{
    for (const test::TestMesh& mesh : test::multiscale_meshes()) {
        SCOPED_TRACE(mesh.name);
        const Topology& t = mesh.topology;
        const MultiscaleHierarchy h = build_hierarchy(t, mesh.points);
        for (const PatchNode& node : h.nodes) {
            const auto vertices = part(h.vertices, node.vertices);
            std::set<int> corners, edges;
            for (const int f : part(h.faces, node.faces))
                for (int c = 0; c < 3; ++c) {
                    corners.insert(t.faces()(f, c));
                    edges.insert(t.face_edges()(f, c));
                }
            EXPECT_EQ(as_set(vertices), corners);
            EXPECT_EQ(edges.size(), to_size(node.edges.count));
            std::map<int, int> copies;
            for (const PatchNode& child : children(h, node)) {
                const auto rows = part(h.in_parent, child.vertices);
                for (std::size_t v = 0; v < rows.size(); ++v)
                    EXPECT_EQ(part(h.vertices, child.vertices)[v], vertices[to_size(rows[v])]);
                EXPECT_TRUE(std::is_sorted(rows.begin(), rows.end())); // one order for all patches
                for (const PatchEdge& edge : part(h.edges, child.edges))
                    ++copies[edge.edge];
            }
            for (const PatchEdge& edge : part(h.edges, node.edges)) {
                EXPECT_EQ(edges.count(edge.edge), 1U);
                EXPECT_LT(edge.lower, edge.upper);
                EXPECT_EQ(t.find_edge(vertices[to_size(edge.lower)], vertices[to_size(edge.upper)]),
                          edge.edge);
                EXPECT_EQ(edge.copies, copies[edge.edge]);
            }
        }
    }
}

TEST(MultiscaleHierarchy, OverlapsListAllCommonVertices)
{
    for (const test::TestMesh& mesh : test::multiscale_meshes()) {
        SCOPED_TRACE(mesh.name);
        const MultiscaleHierarchy h = build_hierarchy(mesh.topology, mesh.points);
        for (const PatchNode& node : h.nodes) {
            std::map<std::pair<int, int>, std::set<int>> listed;
            std::vector<int> largest(to_size(node.child_count), 0);
            for (const PatchOverlap& overlap : part(h.overlaps, node.overlaps)) {
                const auto row = [&](int child, int v) {
                    const PatchNode& patch = children(h, node)[to_size(child)];
                    return part(h.vertices, patch.vertices)[to_size(v)];
                };
                ASSERT_LT(overlap.first, overlap.second);
                for (const CommonVertex& common : part(h.common, {overlap.begin, overlap.count})) {
                    EXPECT_EQ(row(overlap.first, common.first), row(overlap.second, common.second));
                    listed[{overlap.first, overlap.second}].insert(
                        row(overlap.first, common.first));
                }
                int& most = largest[to_size(overlap.second)];
                most = std::max(most, overlap.count);
            }
            for (int k = 0; k < node.child_count; ++k)
                for (int l = k + 1; l < node.child_count; ++l) {
                    const std::set<int> first =
                        as_set(part(h.vertices, children(h, node)[to_size(k)].vertices));
                    const std::set<int> second =
                        as_set(part(h.vertices, children(h, node)[to_size(l)].vertices));
                    std::set<int> both;
                    std::set_intersection(first.begin(), first.end(), second.begin(), second.end(),
                                          std::inserter(both, both.end()));
                    EXPECT_EQ((listed[{k, l}]), both);
                }
            // A patch can be placed on those before it: they share a triangle.
            for (std::size_t k = 1; k < largest.size(); ++k)
                EXPECT_GE(largest[k], 3);
        }
    }
}

TEST(MultiscaleHierarchy, GluingPlacesEveryVertexOfALeafOnce)
{
    for (const test::TestMesh& mesh : test::multiscale_meshes()) {
        SCOPED_TRACE(mesh.name);
        const Topology& t = mesh.topology;
        const MultiscaleHierarchy h = build_hierarchy(t, mesh.points);
        for (const PatchNode& node : h.nodes) {
            if (!node.is_leaf())
                continue;
            const auto vertices = part(h.vertices, node.vertices);
            const auto edge = [&](int a, int b) {
                return t.find_edge(vertices[to_size(a)], vertices[to_size(b)]);
            };
            std::set<int> placed;
            for (const GlueStep& step : part(h.gluing, node.gluing)) {
                const auto& v = step.vertices;
                const bool is_first = placed.empty();
                EXPECT_EQ(step.edges[0], edge(v[0], v[1]));
                EXPECT_EQ(step.edges[1], edge(v[0], v[is_first ? 2 : 3]));
                EXPECT_EQ(step.edges[2], edge(v[1], v[is_first ? 2 : 3]));
                for (std::size_t c = 0; c < 3; ++c)
                    EXPECT_EQ(placed.insert(v[c]).second, is_first);
                if (!is_first) {
                    EXPECT_TRUE(placed.insert(v[3]).second);
                }
            }
            EXPECT_EQ(placed.size(), vertices.size());
        }
    }
}

TEST(MultiscaleHierarchy, IsTheSameForAnyThreadCountAndAnotherForAnotherSeed)
{
    const test::TestMesh mesh = test::bumpy_sphere(4, 0.3, 5);
    const int threads = thread_count();
    set_thread_count(1);
    const MultiscaleHierarchy one = build_hierarchy(mesh.topology, mesh.points);
    set_thread_count(2);
    const MultiscaleHierarchy two = build_hierarchy(mesh.topology, mesh.points);
    set_thread_count(threads);
    EXPECT_EQ(one.faces, two.faces);
    EXPECT_EQ(one.vertices, two.vertices);
    EXPECT_EQ(one.in_parent, two.in_parent);
    EXPECT_GT(one.subtrees.size(), 1U);
    EXPECT_NE(build_hierarchy(mesh.topology, mesh.points, {.seed = 2}).faces, one.faces);
}

TEST(MultiscaleHierarchy, TakesAnyNumberOfChildrenInItsRange)
{
    const test::TestMesh mesh = test::torus(9, 16);
    for (const int m : {4, 5, 9, max_patches}) {
        const MultiscaleHierarchy h = build_hierarchy(mesh.topology, mesh.points, {.children = m});
        for (const PatchNode& node : h.nodes)
            EXPECT_TRUE(node.is_leaf() || node.child_count == m);
        EXPECT_EQ(h.nodes[0].child_count, m);
    }
    const test::TestMesh large = test::icosphere(5); // which is split before its parts are
    const MultiscaleHierarchy h = build_hierarchy(large.topology, large.points, {.children = 5});
    ASSERT_GT(h.subtrees.size(), 1U);
    for (const PatchNode& node : h.nodes)
        EXPECT_TRUE(node.is_leaf() || node.child_count == 5);
    EXPECT_THROW((void)build_hierarchy(mesh.topology, mesh.points, {.children = 3}), InvalidInput);
    EXPECT_THROW((void)build_hierarchy(mesh.topology, mesh.points, {.children = max_patches + 1}),
                 InvalidInput);
    EXPECT_THROW((void)build_hierarchy(mesh.topology, mesh.points.topRows(5)), InvalidInput);
}

} // namespace
} // namespace shape
