// SPDX-License-Identifier: MIT

#include "libshape/conformal/central_vertex.h"

#include <algorithm>
#include <limits>
#include <numbers>
#include <numeric>
#include <queue>
#include <utility>
#include <vector>

#include "libshape/base/to_size.h"
#include "libshape/mesh/edge_lengths.h"

namespace shape::internal {
namespace {

/// Distances along edges from a vertex, at most those given before.
void lower_distances(const Topology& topology, const Eigen::VectorXd& lengths, int source,
                     Eigen::VectorXd& distances)
{
    using Entry = std::pair<double, int>;
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
    distances[source] = 0.0;
    queue.emplace(0.0, source);
    while (!queue.empty()) {
        const auto [distance, v] = queue.top();
        queue.pop();
        if (distance > distances[v])
            continue;
        for (const int h : topology.outgoing(v)) {
            const double next = distance + lengths[topology.edge(h)];
            if (next < distances[topology.target(h)]) {
                distances[topology.target(h)] = next;
                queue.emplace(next, topology.target(h));
            }
        }
    }
}

/// Largest distance to a handful of far apart vertices: small in the middle of the surface.
Eigen::VectorXd eccentricities(const Topology& topology, const Eigen::VectorXd& lengths)
{
    const double infinity = std::numeric_limits<double>::infinity();
    Eigen::VectorXd nearest = Eigen::VectorXd::Constant(topology.vertex_count(), infinity);
    Eigen::VectorXd farthest = Eigen::VectorXd::Zero(topology.vertex_count());
    int source = 0;
    lower_distances(topology, lengths, source, nearest);
    nearest.maxCoeff(&source);
    nearest.setConstant(infinity);
    for (int round = 0; round < 6; ++round) {
        Eigen::VectorXd distances = Eigen::VectorXd::Constant(topology.vertex_count(), infinity);
        lower_distances(topology, lengths, source, distances);
        farthest = farthest.cwiseMax(distances);
        nearest = nearest.cwiseMin(distances);
        nearest.maxCoeff(&source);
    }
    return farthest;
}

/// Smallest of the angles in the faces around a vertex and of pi - (sum of the opposite angles)
/// over its edges and those of its link.
double star_quality(const Topology& topology, const Points& angles, int vertex)
{
    double quality = std::numbers::pi;
    const auto opposite_angle = [&](int h) {
        const int before = Topology::previous(h);
        return angles(Topology::face(before), before % 3);
    };
    const auto delaunay_margin = [&](int h) {
        return std::numbers::pi - opposite_angle(h) - opposite_angle(topology.opposite(h));
    };
    for (const int h : topology.outgoing(vertex)) {
        const int link = Topology::next(h);
        quality = std::min({quality, angles.row(Topology::face(h)).minCoeff(), delaunay_margin(h),
                            delaunay_margin(link)});
    }
    return quality;
}

} // namespace

int central_vertex(const Topology& topology, const Eigen::VectorXd& lengths)
{
    const Eigen::VectorXd eccentricity = eccentricities(topology, lengths);
    const Points angles = corner_angles(topology, lengths);
    std::vector<int> order(to_size(topology.vertex_count()));
    std::iota(order.begin(), order.end(), 0);
    std::sort(order.begin(), order.end(), [&](int a, int b) {
        return std::pair(eccentricity[a], a) < std::pair(eccentricity[b], b);
    });
    order.resize(std::max<std::size_t>(std::min<std::size_t>(order.size(), 20), order.size() / 20));
    int best = order.front();
    double best_quality = -std::numeric_limits<double>::infinity();
    for (const int v : order)
        if (const double quality = star_quality(topology, angles, v); quality > best_quality) {
            best = v;
            best_quality = quality;
        }
    return best;
}

} // namespace shape::internal
