// SPDX-License-Identifier: MIT

#include "libshape/mesh/congruent_meshes.h"

#include <algorithm>
#include <cmath>

#include "libshape/base/threads.h"
#include "libshape/base/to_size.h"
#include "libshape/mesh/alignment.h"
#include "libshape/mesh/edge_lengths.h"

namespace shape::internal {
namespace {

/// Compares edge by edge, as two different meshes of one size seldom agree in more than the first.
bool have_equal_lengths(const Topology& topology, const Points& a, const Points& b, double bound)
{
    const auto length = [&](const Points& points, int e) {
        const int h = topology.edge_halfedges()(e, 0);
        return (points.row(topology.source(h)) - points.row(topology.target(h))).norm();
    };
    for (int e = 0; e < topology.edge_count(); ++e)
        if (!(std::abs(length(a, e) - length(b, e)) <= bound))
            return false;
    return true;
}

bool are_congruent(const Topology& topology, const Points& a, const Points& b, double bound)
{
    return have_equal_lengths(topology, a, b, bound) &&
           (best_rigid_motion(b, a)(b) - a).rowwise().norm().maxCoeff() <= bound;
}

} // namespace

std::vector<std::vector<std::size_t>> congruent_meshes(const Topology& topology,
                                                       std::span<const Points> meshes)
{
    std::vector<double> sizes(meshes.size());
    parallel_for(meshes.size(), 8, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i)
            sizes[i] = edge_lengths(topology, meshes[i]).sum();
    });
    std::vector<std::size_t> order(meshes.size());
    for (std::size_t i = 0; i < order.size(); ++i)
        order[i] = i;
    std::ranges::stable_sort(order, {}, [&](std::size_t i) { return sizes[i]; });

    std::vector<char> is_listed(meshes.size(), 0);
    std::vector<std::vector<std::size_t>> lists;
    for (std::size_t k = 0; k < order.size(); ++k) {
        const std::size_t first = order[k];
        if (is_listed[first] != 0)
            continue;
        std::vector<std::size_t> list{first};
        const Points& points = meshes[first];
        const double bound = 1e-6 * bounding_box_diagonal(points);
        const double largest = sizes[first] + bound * topology.edge_count();
        for (std::size_t n = k + 1; n < order.size() && sizes[order[n]] <= largest; ++n)
            if (is_listed[order[n]] == 0 &&
                are_congruent(topology, points, meshes[order[n]], bound)) {
                is_listed[order[n]] = 1;
                list.push_back(order[n]);
            }
        if (list.size() == 1)
            continue;
        std::ranges::sort(list);
        lists.push_back(std::move(list));
    }
    std::ranges::sort(lists);
    return lists;
}

} // namespace shape::internal
