// SPDX-License-Identifier: MIT

#include "libshape/mesh/vertex_regions.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <queue>
#include <set>

#include "libshape/base/random.h"
#include "libshape/base/to_size.h"
#include "tests/support/meshes.h"

namespace shape::test {
using namespace internal;
namespace {

/// Distance of every vertex from the nearest seed, in edges.
std::vector<int> distances(const Topology& topology, const std::vector<int>& seeds)
{
    std::vector<int> distance(to_size(topology.vertex_count()), -1);
    std::queue<int> queue;
    for (const int v : seeds) {
        distance[to_size(v)] = 0;
        queue.push(v);
    }
    for (; !queue.empty(); queue.pop())
        for (int e = 0; e < topology.edge_count(); ++e)
            for (const int side : {0, 1})
                if (topology.edges()(e, side) == queue.front()) {
                    const int other = topology.edges()(e, 1 - side);
                    if (distance[to_size(other)] < 0) {
                        distance[to_size(other)] = distance[to_size(queue.front())] + 1;
                        queue.push(other);
                    }
                }
    return distance;
}

TEST(VertexRegions, AreTheVerticesWithinSoManyEdges)
{
    Random random(3);
    for (const TestMesh& mesh : sample_meshes()) {
        const Topology& topology = mesh.topology;
        for (int rings = 0; rings <= 3; ++rings) {
            std::vector<int> seeds;
            for (int k = 0; k < 4; ++k)
                seeds.push_back(static_cast<int>(
                    random.index(static_cast<std::uint64_t>(topology.vertex_count()))));
            const std::vector<int> distance = distances(topology, seeds);
            std::set<int> expected;
            for (int v = 0; v < topology.vertex_count(); ++v)
                if (distance[to_size(v)] <= rings)
                    expected.insert(v);
            std::set<int> found;
            std::size_t count = 0;
            for (const std::vector<int>& region : regions_around(topology, seeds, rings)) {
                found.insert(region.begin(), region.end());
                count += region.size();
            }
            EXPECT_EQ(found, expected);
            EXPECT_EQ(count, found.size()) << "a vertex lies in two regions";
        }
    }
}

TEST(VertexRegions, AreConnectedAndApartInAscendingOrder)
{
    const TestMesh mesh = open_cylinder(16, 20);
    const Topology& t = mesh.topology;
    const std::vector<std::vector<int>> regions = regions_around(t, {300, 5, 6, 150, 5}, 1);
    std::vector<int> region_of(to_size(t.vertex_count()), -1);
    int last = -1;
    for (std::size_t k = 0; k < regions.size(); ++k) {
        EXPECT_EQ(regions[k].front(), *std::min_element(regions[k].begin(), regions[k].end()));
        EXPECT_GT(regions[k].front(), last);
        last = regions[k].front();
        for (const int v : regions[k])
            region_of[to_size(v)] = static_cast<int>(k);
    }
    for (int e = 0; e < t.edge_count(); ++e) {
        const int a = region_of[to_size(t.edges()(e, 0))];
        const int b = region_of[to_size(t.edges()(e, 1))];
        EXPECT_TRUE(a == b || a < 0 || b < 0) << "regions " << a << " and " << b << " touch";
    }
    EXPECT_EQ(regions.size(), 3U); // 5 and 6 are neighbours
}

TEST(VertexRegions, AreNoneWithoutSeeds)
{
    EXPECT_TRUE(regions_around(tetrahedron().topology, {}, 2).empty());
    EXPECT_EQ(regions_around(tetrahedron().topology, {2}, 0), (std::vector<std::vector<int>>{{2}}));
}

} // namespace
} // namespace shape::test
