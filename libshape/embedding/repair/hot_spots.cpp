// SPDX-License-Identifier: MIT

#include "libshape/embedding/repair/hot_spots.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "libshape/base/require.h"
#include "libshape/base/threads.h"
#include "libshape/base/to_size.h"
#include "libshape/embedding/energy/stretch_term.h"
#include "libshape/mesh/vertex_regions.h"

namespace shape::internal {

using Eigen::VectorXd;

void check(const HotSpotOptions& options)
{
    require_not_negative(options.seeds, "HotSpotOptions.seeds");
    require_not_negative(options.contrast, "HotSpotOptions.contrast");
    require_at_least(0, options.rings, "HotSpotOptions.rings");
}

std::vector<std::vector<int>> hot_spots(const LengthDihedralEnergy& energy, const VectorXd& points,
                                        const HotSpotOptions& options)
{
    check(options);
    const Topology& t = energy.topology();
    const auto vertices = to_size(t.vertex_count());
    constexpr std::size_t grain = 8192;
    std::vector<float> stretch(to_size(t.edge_count())); // of edges
    parallel_for(stretch.size(), grain, [&](std::size_t begin, std::size_t end) {
        for (auto e = static_cast<int>(begin); e < static_cast<int>(end); ++e) {
            const double length =
                (points.segment<3>(3 * t.edges()(e, 1)) - points.segment<3>(3 * t.edges()(e, 0)))
                    .norm();
            stretch[to_size(e)] = static_cast<float>(
                stretch_term(length / energy.target().edge_lengths[e] - 1.0).value);
        }
    });
    std::vector<float> strain(vertices, 0.0F); // of vertices
    for (int e = 0; e < t.edge_count(); ++e)
        for (const int side : {0, 1})
            strain[to_size(t.edges()(e, side))] += stretch[to_size(e)];

    std::vector<int> order(vertices);
    std::iota(order.begin(), order.end(), 0);
    const auto all = static_cast<double>(vertices);
    const auto count = static_cast<std::size_t>(std::min(options.seeds * std::sqrt(all), all));
    const auto by_strain = [&](int a, int b) {
        return std::pair(-strain[to_size(a)], a) < std::pair(-strain[to_size(b)], b);
    };
    std::nth_element(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(count), order.end(),
                     by_strain);
    order.resize(count);
    const double mean = std::accumulate(strain.begin(), strain.end(), 0.0) / all;
    std::erase_if(order, [&](int v) { return !(strain[to_size(v)] > options.contrast * mean); });
    return regions_around(t, order, options.rings);
}

} // namespace shape::internal
