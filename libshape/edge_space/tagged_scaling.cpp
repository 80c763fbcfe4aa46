// SPDX-License-Identifier: MIT

#include "libshape/edge_space/tagged_scaling.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "libshape/base/error.h"
#include "libshape/base/format.h"

namespace shape {
using namespace internal;
namespace {

void check_indices(std::span<const int> indices, int count, const char* what)
{
    for (const int index : indices)
        if (index < 0 || index >= count)
            throw InvalidInput(
                join("tagged ", what, " ", index, " is out of range [0, ", count - 1, "]"));
}

} // namespace

Eigen::VectorXd tagged_shares(const Topology& topology, std::span<const int> vertices, int rings)
{
    check_indices(vertices, topology.vertex_count(), "vertex");
    if (rings < 1)
        throw InvalidInput(join("rings is ", rings, ", must be >= 1"));
    Eigen::VectorXd tags = Eigen::VectorXd::Zero(topology.vertex_count());
    for (const int v : vertices)
        tags[v] = 1.0;
    const auto low = topology.edges().col(0);
    const auto high = topology.edges().col(1);
    // Every pass reaches one ring farther; the last ring counts 0.
    for (int d = 1; d < rings; ++d) {
        const Eigen::VectorXd before = tags;
        for (Eigen::Index e = 0; e < low.size(); ++e)
            for (const auto& [from, to] : {std::pair(low[e], high[e]), std::pair(high[e], low[e])})
                tags[to] = std::max(tags[to], before[from] - 1.0 / rings);
    }
    return 0.5 * (tags(low) + tags(high));
}

std::vector<int> corners_of_faces(const Topology& topology, std::span<const int> faces)
{
    check_indices(faces, topology.face_count(), "face");
    std::vector<int> corners;
    for (const int f : faces)
        for (const int v : topology.faces().row(f))
            corners.push_back(v);
    return corners;
}

ShapePoint scale_tagged(ShapePoint point, const Eigen::VectorXd& shares, double factor)
{
    if (shares.size() != point.edge_lengths.size())
        throw InvalidInput(
            join("there are ", shares.size(), " shares for ", point.edge_lengths.size(), " edges"));
    if (!(factor > 0.0) || !std::isfinite(factor))
        throw InvalidInput(join("the factor of the tagged part is ", factor, ", must be > 0"));
    point.edge_lengths.array() *= 1.0 + shares.array() * (factor - 1.0);
    return point;
}

} // namespace shape
