// SPDX-License-Identifier: MIT

#include "libshape/registration/template_levels.h"

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <queue>

#include "libshape/base/to_size.h"
#include "libshape/mesh/alignment.h"
#include "libshape/mesh/edge_lengths.h"
#include "libshape/registration/coarse_mesh.h"

namespace shape::internal {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Weights = std::vector<std::pair<int, double>>;

/// Weights (1 - d / reach)^2 of the coarse vertices within `reach` along the edges of the fine mesh.
std::vector<Weights> near_vertices(const Topology& fine, const Points& points,
                                   const std::vector<int>& coarse, double reach)
{
    constexpr double infinite = std::numeric_limits<double>::infinity();
    std::vector<Weights> near(to_size(fine.vertex_count()));
    std::vector<double> distance(near.size(), infinite);
    using Entry = std::pair<double, int>;
    for (std::size_t c = 0; c < coarse.size(); ++c) {
        std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
        std::vector<int> reached{coarse[c]};
        distance[to_size(coarse[c])] = 0.0;
        queue.emplace(0.0, coarse[c]);
        while (!queue.empty()) {
            const auto [d, v] = queue.top();
            queue.pop();
            if (d > distance[to_size(v)])
                continue;
            for (const Topology::Spoke& spoke : fine.spokes(v)) {
                double& there = distance[to_size(spoke.vertex)];
                const double next = d + (points.row(v) - points.row(spoke.vertex)).norm();
                if (next < reach && next < there) {
                    if (there == infinite)
                        reached.push_back(spoke.vertex);
                    there = next;
                    queue.emplace(next, spoke.vertex);
                }
            }
        }
        for (const int v : reached) {
            const double t = 1.0 - distance[to_size(v)] / reach;
            near[to_size(v)].emplace_back(static_cast<int>(c), t * t);
            distance[to_size(v)] = infinite;
        }
    }
    // Vertices at the end of very long edges do as a neighbour does.
    std::queue<int> front;
    for (int v = 0; v < fine.vertex_count(); ++v)
        if (!near[to_size(v)].empty())
            front.push(v);
    for (; !front.empty(); front.pop())
        for (const Topology::Spoke& spoke : fine.spokes(front.front()))
            if (near[to_size(spoke.vertex)].empty()) {
                near[to_size(spoke.vertex)] = near[to_size(front.front())];
                front.push(spoke.vertex);
            }
    for (Weights& weights : near) {
        double sum = 0.0;
        for (const auto& [v, weight] : weights)
            sum += weight;
        for (auto& [v, weight] : weights)
            weight /= sum;
    }
    return near;
}

/// As long as twice the area of the faces at a vertex.
Vector3d normal_at(const Topology& topology, const Points& points, int v)
{
    Vector3d normal = Vector3d::Zero();
    const Vector3d here = points.row(v);
    for (const int h : topology.outgoing(v)) {
        const Vector3d a = points.row(topology.target(h));
        const Vector3d b = points.row(topology.source(Topology::previous(h)));
        normal += (a - here).cross(b - here);
    }
    return normal;
}

} // namespace

std::vector<TemplateLevel> template_levels(const Topology& topology, const Points& rest, int least)
{
    std::vector<TemplateLevel> levels{{topology, rest, {}}};
    while (levels.back().topology.vertex_count() / 4 > least) {
        const TemplateLevel& fine = levels.back();
        const int count = fine.topology.vertex_count();
        CoarseMesh coarse = coarsened(fine.topology, fine.rest, count / 4);
        if (coarse.topology.vertex_count() > count / 2)
            break; // no edge may collapse
        // Two edges: every vertex between follows several, so that what it follows changes smoothly.
        const double reach = 2.0 * edge_lengths(coarse.topology, coarse.points).mean();
        auto followers = near_vertices(fine.topology, fine.rest, coarse.vertices, reach);
        levels.push_back(
            {std::move(coarse.topology), std::move(coarse.points), std::move(followers)});
    }
    return levels;
}

LevelMesh carried_to_finer(const TemplateLevel& coarse, const LevelMesh& moved,
                           const TemplateLevel& fine)
{
    const Topology& topology = coarse.topology;
    std::vector<Matrix3d> turns(to_size(topology.vertex_count()));
    for (int v = 0; v < topology.vertex_count(); ++v) {
        Matrix3d m = normal_at(topology, moved.points, v).stableNormalized() *
                     normal_at(topology, coarse.rest, v).stableNormalized().transpose();
        for (const Topology::Spoke& spoke : topology.spokes(v)) {
            const Vector3d before = coarse.rest.row(spoke.vertex) - coarse.rest.row(v);
            const Vector3d now = moved.points.row(spoke.vertex) - moved.points.row(v);
            m += now * before.transpose() / before.squaredNorm();
        }
        turns[to_size(v)] = std::exp(moved.growth[v]) * nearest_rotation(m);
    }
    LevelMesh result;
    result.points = Points::Zero(fine.rest.rows(), 3);
    result.growth = Eigen::VectorXd::Zero(fine.rest.rows());
    for (Eigen::Index i = 0; i < fine.rest.rows(); ++i)
        for (const auto& [v, weight] : coarse.followers[to_size(i)]) {
            const Vector3d arm = fine.rest.row(i) - coarse.rest.row(v);
            result.points.row(i) +=
                weight * (moved.points.row(v) + (turns[to_size(v)] * arm).transpose());
            result.growth[i] += weight * moved.growth[v];
        }
    return result;
}

} // namespace shape::internal
