// SPDX-License-Identifier: MIT

#include "libshape/embedding/energy/graded_unknowns.h"

#include <algorithm>
#include <utility>

#include "libshape/base/to_size.h"

namespace shape::internal {

using Eigen::VectorXd;

namespace {

/// The shortest edge at every vertex [length].
VectorXd vertex_scales(const Topology& topology, const VectorXd& lengths)
{
    VectorXd scales = VectorXd::Constant(topology.vertex_count(), lengths.maxCoeff());
    for (int e = 0; e < topology.edge_count(); ++e)
        for (const int v : {topology.edges()(e, 0), topology.edges()(e, 1)})
            scales[v] = std::min(scales[v], lengths[e]);
    return scales;
}

/// Per vertex, the vertices that carry it: in every region, the one of largest scale carries all.
std::vector<std::vector<int>> fine_regions(const Topology& topology, const VectorXd& scales)
{
    // Terms of E grow as 1 / l^2: within a region they differ by 300^2, about 1e5, which leaves 11 of the
    // 16 digits of double. With a smaller ratio more rows of the matrix fill up.
    constexpr double ratio = 300.0;
    std::vector<std::vector<int>> carriers(to_size(topology.vertex_count()));
    std::vector<char> carries(carriers.size(), 0);
    for (double bound = scales.maxCoeff() / ratio; scales.minCoeff() < bound; bound /= ratio) {
        std::vector<char> seen(carriers.size(), 0);
        for (int v = 0; v < topology.vertex_count(); ++v) {
            std::vector<int> region;
            const auto visit = [&](int w) {
                if (scales[w] < bound && std::exchange(seen[to_size(w)], 1) == 0)
                    region.push_back(w);
            };
            visit(v);
            for (std::size_t i = 0; i < region.size(); ++i)
                for (const int h : topology.outgoing(region[i]))
                    visit(topology.target(h));
            if (region.empty())
                continue;
            const int root = *std::max_element(region.begin(), region.end(),
                                               [&](int a, int b) { return scales[a] < scales[b]; });
            // Larger regions had the same vertex if there is nothing between the bounds.
            if (std::exchange(carries[to_size(root)], 1) != 0)
                continue;
            for (const int w : region)
                if (w != root)
                    carriers[to_size(w)].push_back(root);
        }
    }
    return carriers;
}

} // namespace

GradedUnknowns graded_unknowns(const Topology& topology, const VectorXd& lengths)
{
    const VectorXd scales = vertex_scales(topology, lengths);
    Eigen::Index held = 0;
    scales.maxCoeff(&held);
    GradedUnknowns unknowns{{}, fine_regions(topology, scales)};
    std::vector<int> row(unknowns.rows.size(), -1);
    for (int v = 0; v < topology.vertex_count(); ++v)
        if (v != held) {
            row[to_size(v)] = static_cast<int>(unknowns.vertices.size());
            unknowns.vertices.push_back(v);
        }
    for (std::size_t v = 0; v < row.size(); ++v) {
        for (int& carrier : unknowns.rows[v])
            carrier = row[to_size(carrier)];
        if (row[v] >= 0)
            unknowns.rows[v].push_back(row[v]);
    }
    return unknowns;
}

} // namespace shape::internal
