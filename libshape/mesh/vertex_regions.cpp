// SPDX-License-Identifier: MIT

#include "libshape/mesh/vertex_regions.h"

#include <algorithm>
#include <utility>

#include "libshape/base/to_size.h"

namespace shape::internal {
namespace {

template <class Visit>
void for_neighbours(const Topology& topology, int vertex, const Visit& visit)
{
    for (const int h : topology.outgoing(vertex)) {
        visit(topology.target(h));
        visit(topology.source(Topology::previous(h)));
    }
}

} // namespace

std::vector<std::vector<int>> regions_around(const Topology& topology,
                                             const std::vector<int>& seeds, int rings)
{
    std::vector<char> marked(to_size(topology.vertex_count()), 0);
    std::vector<int> all;
    const auto mark = [&](int v) {
        if (!std::exchange(marked[to_size(v)], 1))
            all.push_back(v);
    };
    for (const int v : seeds)
        mark(v);
    std::size_t front = 0;
    for (int ring = 0; ring < rings; ++ring)
        for (const std::size_t end = all.size(); front < end; ++front)
            for_neighbours(topology, all[front], mark);

    std::sort(all.begin(), all.end());
    std::vector<std::vector<int>> regions;
    for (const int first : all) {
        std::vector<int> region;
        const auto take = [&](int v) {
            if (std::exchange(marked[to_size(v)], 0))
                region.push_back(v);
        };
        take(first);
        for (std::size_t i = 0; i < region.size(); ++i) // it grows on the way
            for_neighbours(topology, region[i], take);
        if (!region.empty())
            regions.push_back(std::move(region));
    }
    return regions;
}

} // namespace shape::internal
