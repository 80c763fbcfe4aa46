// SPDX-License-Identifier: MIT

#include "libshape/registration/surface_pulls.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

#include "libshape/base/threads.h"
#include "libshape/base/to_size.h"
#include "libshape/mesh/points.h"
#include "libshape/mesh/vertex_normals.h"

namespace shape::internal {
namespace {

using Eigen::Index;
using Eigen::Vector3d;

/// Normals of a pair enclose at most some 70 degrees.
constexpr double least_cosine = 0.3;

/// Scans in pieces may have thousands of small holes: so many loops, the longest, are looked at.
constexpr std::size_t most_loops = 40;

double welsch(double distance, double scale)
{
    return std::exp(-0.5 * distance * distance / (scale * scale));
}

/// Nearest points of some points with normals, in parallel.
/// @param faces  Those of the last ones, to begin with; then theirs.
std::vector<SurfacePoint> nearest_points(const ClosestPoints& tree, const Points& points,
                                         const Points& normals, double within,
                                         std::vector<int>& faces)
{
    std::vector<SurfacePoint> found(to_size(points.rows()));
    faces.resize(found.size(), -1);
    parallel_for(found.size(), 256, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const auto row = static_cast<Index>(i);
            NearestRule rule;
            rule.within = within;
            rule.normal = normals.row(row);
            rule.least_cosine = least_cosine;
            rule.guess = faces[i];
            found[i] = tree.nearest(points.row(row), rule);
            faces[i] = found[i].face;
        }
    });
    return found;
}

/// A pull across a curve: the three rows of the projection onto the plane normal to it.
void add_pull_across(int vertex, const Vector3d& along, const Vector3d& move, double weight,
                     GrowthEnergy& energy)
{
    for (int axis = 0; axis < 3; ++axis) {
        const Vector3d direction = Vector3d::Unit(axis) - Vector3d::Unit(axis).dot(along) * along;
        energy.add_pull(vertex, direction, direction.dot(move), weight);
    }
}

/// Mean distance of the middles of a curve's edges from another curve.
double mean_distance(const RimCurve& from, const Points& points, const RimCurve& to)
{
    double sum = 0.0;
    for (const Rims::Edge& edge : from.edges) {
        const Vector3d a = points.row(edge.from), b = points.row(edge.to);
        sum += (b - a).norm() * to.tree.nearest(0.5 * (a + b)).distance;
    }
    return sum / from.length;
}

void add_loop_pulls(const Surface& scan, const RimCurve& of_scan, const RimCurve& of_mesh,
                    const Points& points, bool is_open, const PullRule& rule, GrowthEnergy& energy)
{
    std::map<int, Vector3d> outward; // of the mesh's vertices on the loop
    for (std::size_t i = 0; i < of_mesh.edges.size(); ++i)
        for (const int v : {of_mesh.edges[i].from, of_mesh.edges[i].to})
            outward.try_emplace(v, Vector3d::Zero()).first->second +=
                of_mesh.outward.row(static_cast<Index>(i));
    std::vector<double> distances;
    for (const auto& [v, direction] : outward)
        distances.push_back(of_scan.tree.nearest(points.row(v)).distance);
    const auto middle = distances.begin() + std::ssize(distances) / 2;
    std::nth_element(distances.begin(), middle, distances.end());
    const double diagonal = bounding_box_diagonal(points);
    // Half of the loop lies within the median, so a few medians keep what belongs together; the second terms let a loop
    // that fits already move on. Where a scan ends anywhere, what is far from the template's end is not that end.
    const double scale = is_open ? std::max(2.5 * *middle, 0.003 * diagonal)
                                 : std::max(4.0 * *middle, 0.05 * diagonal);
    const auto along = [](const Rims::Edge& edge, const Points& of) {
        return Vector3d(of.row(edge.to) - of.row(edge.from)).stableNormalized();
    };
    for (const auto& [v, direction] : outward) {
        NearestRule nearest;
        nearest.normal = direction.stableNormalized();
        nearest.least_cosine = least_cosine;
        const Vector3d here = points.row(v);
        const SurfacePoint pair = of_scan.tree.nearest(here, nearest);
        if (pair.face >= 0)
            add_pull_across(v, along(of_scan.edges[to_size(pair.face)], scan.points),
                            pair.position - here, rule.weight * welsch(pair.distance, scale),
                            energy);
    }
    const double share =
        static_cast<double>(outward.size()) / static_cast<double>(of_scan.edges.size());
    for (std::size_t i = 0; i < of_scan.edges.size(); ++i) {
        const Rims::Edge& edge = of_scan.edges[i];
        NearestRule nearest;
        nearest.normal = of_scan.outward.row(static_cast<Index>(i));
        nearest.least_cosine = least_cosine;
        const Vector3d there = 0.5 * (scan.points.row(edge.from) + scan.points.row(edge.to));
        const SurfacePoint pair = of_mesh.tree.nearest(there, nearest);
        if (pair.face < 0)
            continue;
        const Rims::Edge& mine = of_mesh.edges[to_size(pair.face)];
        const double weight = rule.weight * share * welsch(pair.distance, scale);
        const Vector3d move = there - pair.position;
        add_pull_across(mine.from, along(edge, scan.points), move, weight * pair.barycentric[0],
                        energy);
        add_pull_across(mine.to, along(edge, scan.points), move,
                        weight * (pair.barycentric[1] + pair.barycentric[2]), energy);
    }
}

} // namespace

void add_surface_pulls(const Surface& scan, const Topology& topology, const Points& points,
                       const PullRule& rule, GrowthEnergy& energy, LastPairs& last)
{
    const double within = 4.0 * rule.scale; // beyond, Welsch's weight is below exp(-8) = 3e-4
    const Points normals = vertex_normals(points, topology.faces());
    const std::vector<SurfacePoint> on_scan =
        nearest_points(scan.tree, points, normals, within, last.on_scan);
    for (int v = 0; v < topology.vertex_count(); ++v) {
        const SurfacePoint& pair = on_scan[to_size(v)];
        if (pair.face < 0 || scan.ends_at(pair))
            continue;
        const Vector3d normal =
            (scan.normal_at(pair) + normals.row(v).transpose()).stableNormalized();
        energy.add_pull(v, normal, normal.dot(pair.position - points.row(v).transpose()),
                        rule.weight * welsch(pair.distance, rule.scale));
    }

    const ClosestPoints mesh(points, topology.faces());
    const Index stride = std::max<Index>(1, scan.points.rows() / topology.vertex_count());
    const auto some = Eigen::seq(0, scan.points.rows() - 1, stride);
    const Points samples = scan.points(some, Eigen::all);
    const Points sample_normals = scan.normals(some, Eigen::all);
    const std::vector<SurfacePoint> on_mesh =
        nearest_points(mesh, samples, sample_normals, within, last.on_mesh);
    const double share =
        static_cast<double>(topology.vertex_count()) / static_cast<double>(samples.rows());
    for (Index i = 0; i < samples.rows(); ++i) {
        const SurfacePoint& pair = on_mesh[to_size(i)];
        if (pair.face < 0)
            continue;
        const auto corners = topology.faces().row(pair.face);
        bool ends = false;
        Vector3d normal = Vector3d::Zero();
        for (int k = 0; k < 3; ++k) {
            ends = ends || (pair.barycentric[k] > 0.0 && pair.barycentric.minCoeff() < 1e-9 &&
                            topology.is_boundary_vertex(corners[k]));
            normal += pair.barycentric[k] * normals.row(corners[k]).transpose();
        }
        if (ends)
            continue;
        normal = (normal.stableNormalized() + sample_normals.row(i).transpose()).stableNormalized();
        const double distance = normal.dot(samples.row(i).transpose() - pair.position);
        const double weight = share * rule.weight * welsch(pair.distance, rule.scale);
        for (int k = 0; k < 3; ++k) // as if each corner moved all of it: no less than what is meant
            energy.add_pull(corners[k], normal, distance, weight * pair.barycentric[k]);
    }
}

void add_rim_pulls(const Surface& scan, const Rims& rims, const Points& points,
                   const std::vector<std::pair<int, int>>& named, const PullRule& rule,
                   GrowthEnergy& energy)
{
    const auto curves_of = [](const Rims& of, const Points& at) {
        std::vector<double> lengths(to_size(of.loop_count), 0.0);
        for (const Rims::Edge& edge : of.edges)
            lengths[to_size(edge.loop)] += (at.row(edge.to) - at.row(edge.from)).norm();
        std::vector<int> loops(lengths.size());
        for (std::size_t i = 0; i < loops.size(); ++i)
            loops[i] = static_cast<int>(i);
        std::stable_sort(loops.begin(), loops.end(),
                         [&](int a, int b) { return lengths[to_size(a)] > lengths[to_size(b)]; });
        loops.resize(std::min(loops.size(), most_loops));
        std::map<int, RimCurve> curves;
        for (const int loop : loops)
            if (lengths[to_size(loop)] > 0.0)
                curves.emplace(loop, RimCurve(of, loop, at));
        return std::pair(std::move(curves), loops.empty() ? -1 : loops.front());
    };
    if (rims.edges.empty() || scan.rims.edges.empty())
        return;
    const auto [of_mesh, longest] = curves_of(rims, points);
    const auto [of_scan, unused] = curves_of(scan.rims, scan.points);

    std::vector<std::tuple<double, int, int>> pairs; // relative distance, loops
    for (const auto& [mine, a] : of_mesh)
        for (const auto& [other, b] : of_scan) {
            if (std::find(named.begin(), named.end(), std::pair(mine, other)) != named.end()) {
                pairs.emplace_back(-1.0, mine, other);
                continue;
            }
            const double shorter = std::min(a.length, b.length);
            if (std::max(a.length, b.length) > 2.0 * shorter)
                continue; // an opened mouth's rim is that of the closed one within this
            const double apart =
                std::max(mean_distance(a, points, b), mean_distance(b, scan.points, a));
            if (apart < 0.1 * shorter) // a circle's own diameter is 0.32 of its length
                pairs.emplace_back(apart / shorter, mine, other);
        }
    std::sort(pairs.begin(), pairs.end());
    std::vector<int> mine_taken, others_taken;
    const auto contains = [](const std::vector<int>& in, int loop) {
        return std::find(in.begin(), in.end(), loop) != in.end();
    };
    for (const auto& [apart, mine, other] : pairs) {
        if (contains(mine_taken, mine) || contains(others_taken, other))
            continue;
        mine_taken.push_back(mine);
        others_taken.push_back(other);
        const bool is_open = mine == longest && apart >= 0.0;
        add_loop_pulls(scan, of_scan.at(other), of_mesh.at(mine), points, is_open, rule, energy);
    }
}

} // namespace shape::internal
