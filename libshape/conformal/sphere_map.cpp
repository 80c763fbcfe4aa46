// SPDX-License-Identifier: MIT

#include "libshape/conformal/sphere_map.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <queue>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/conformal/angle_defect_energy.h"
#include "libshape/conformal/flat_metric.h"
#include "libshape/mesh/edge_lengths.h"

namespace shape {
namespace {

using std::numbers::pi;

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
    double quality = pi;
    const auto opposite_angle = [&](int h) {
        const int before = Topology::previous(h);
        return angles(Topology::face(before), before % 3);
    };
    for (const int h : topology.outgoing(vertex)) {
        const int link = Topology::next(h);
        quality = std::min({quality, angles.row(Topology::face(h)).minCoeff(),
                            pi - opposite_angle(h) - opposite_angle(topology.opposite(h)),
                            pi - opposite_angle(link) - opposite_angle(topology.opposite(link))});
    }
    return quality;
}

/// A vertex with a well-shaped star among the most central twentieth of all.
int choose_removed_vertex(const Topology& topology, const Eigen::VectorXd& lengths)
{
    const Eigen::VectorXd eccentricity = eccentricities(topology, lengths);
    const Points angles = corner_angles(topology, lengths);
    std::vector<int> order(static_cast<std::size_t>(topology.vertex_count()));
    for (int v = 0; v < topology.vertex_count(); ++v)
        order[static_cast<std::size_t>(v)] = v;
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

} // namespace

std::string why_not_spherical(const Topology& topology)
{
    if (!topology.is_closed())
        return join("the mesh has ", topology.boundary_loop_count(),
                    " boundary loop(s), a map to the sphere needs a closed surface; close the "
                    "holes, or flatten it as a disc");
    if (topology.genus() > 0)
        return join("the mesh has genus ", topology.genus(),
                    ", a map to the sphere needs genus 0; cut or fill the handles");
    return {};
}

SphereMap map_to_sphere(const Topology& topology, const Eigen::VectorXd& lengths,
                        const SphereMapOptions& options)
{
    if (const std::string reason = why_not_spherical(topology); !reason.empty())
        throw InvalidInput(reason);
    const int vertex_count = topology.vertex_count();
    SphereMap map;
    map.removed_vertex = options.removed_vertex >= 0 ? options.removed_vertex
                                                     : choose_removed_vertex(topology, lengths);
    const int v0 = map.removed_vertex;
    const FlatMetric flat =
        flatten_punctured_sphere(IntrinsicTriangulation(topology, lengths), v0);
    const IntrinsicTriangulation& t = flat.triangulation;
    const PlanarLayout& layout = flat.layout;
    const Eigen::VectorXd& u = flat.u;
    const std::vector<int>& link = flat.boundary;
    map.newton_steps = flat.newton_steps;
    map.flip_rounds = flat.rounds;
    map.angle_residual = flat.angle_residual;
    map.broken = flat.broken_faces.size();

    Eigen::VectorXd weights = Eigen::VectorXd::Zero(vertex_count);
    double area = 0.0;
    for (int f = 0; f < topology.face_count(); ++f) {
        const double a = lengths[topology.face_edges()(f, 0)];
        const double b = lengths[topology.face_edges()(f, 1)];
        const double c = lengths[topology.face_edges()(f, 2)];
        const double face_area =
            0.25 * std::sqrt(std::max(0.0, (a + b + c) * (-a + b + c) * (a - b + c) * (a + b - c)));
        area += face_area;
        for (int k = 0; k < 3; ++k)
            weights[topology.faces()(f, k)] += face_area / 3.0;
    }
    map.radius = std::sqrt(area / (4.0 * pi));
    const MoebiusBalance balance = balance_on_sphere(layout.positions, weights, v0);
    map.balance_residual = balance.residual;
    map.sphere = project_to_sphere(layout, balance.frame, v0);

    map.factors = u;
    const double shift = std::log(2.0 * map.radius / balance.frame.height);
    map.factors[v0] = 0.0;
    for (int v = 0; v < vertex_count; ++v)
        if (v != v0) {
            const double distance = std::abs(layout.positions[v] - balance.frame.centre);
            map.factors[v] +=
                shift - 2.0 * std::log(std::hypot(1.0, distance / balance.frame.height));
        }
    const auto chord = [&](int a, int b) -> Eigen::RowVector3d {
        return (map.sphere.points.row(b) - map.sphere.points.row(a)) +
               (map.sphere.remainders.row(b) - map.sphere.remainders.row(a));
    };
    for (const int h : link) {
        const int v = t.source(h);
        const double b = map.radius * chord(v0, v).norm();
        for (const int s : t.ring(t.first_halfedges()[static_cast<std::size_t>(v0)]))
            if (t.target(s) == v)
                map.factors[v0] += (2.0 * (std::log(b) - t.log_lengths()[t.edge(s)]) -
                                    map.factors[v]) /
                                   static_cast<double>(link.size());
    }
    map.edge_residuals.resize(t.edge_count());
    for (int e = 0; e < t.edge_count(); ++e) {
        const int a = topology.edges()(e, 0);
        const int b = topology.edges()(e, 1);
        map.edge_residuals[e] = std::log(map.radius * chord(a, b).norm() / lengths[e]) -
                                0.5 * (map.factors[a] + map.factors[b]);
        const int h = t.halfedge(e);
        if (std::minmax(t.source(h), t.target(h)) != std::minmax(a, b))
            map.flipped_edges.push_back(e);
        else
            map.residual = std::max(map.residual, std::abs(map.edge_residuals[e]));
    }
    for (int f = 0; f < topology.face_count(); ++f) {
        const Eigen::RowVector3i v = topology.faces().row(f);
        const Eigen::RowVector3d p = map.sphere.points.row(v[0]);
        if (p.dot(chord(v[0], v[1]).cross(chord(v[0], v[2]))) <= 0.0)
            map.reversed_faces.push_back(f);
    }
    map.certificate = map.flipped_edges.empty() ? ConformalCertificate::Exact
                                                : ConformalCertificate::Repaired;
    return map;
}

} // namespace shape
