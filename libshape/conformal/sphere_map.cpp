// SPDX-License-Identifier: MIT

#include "libshape/conformal/sphere_map.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "libshape/base/counted.h"
#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/require.h"
#include "libshape/conformal/central_vertex.h"
#include "libshape/conformal/conformal_edges.h"
#include "libshape/conformal/flat_metric.h"
#include "libshape/conformal/moebius.h"
#include "libshape/mesh/triangle_area.h"

namespace shape {
using namespace internal;
namespace {

/// Areas of the faces by Heron's formula [length^2], 0 where a triangle inequality is broken.
Eigen::VectorXd face_areas(const Topology& topology, const Eigen::VectorXd& lengths)
{
    Eigen::VectorXd areas(topology.face_count());
    for (int f = 0; f < topology.face_count(); ++f) {
        const double a = lengths[topology.face_edges()(f, 0)];
        const double b = lengths[topology.face_edges()(f, 1)];
        const double c = lengths[topology.face_edges()(f, 2)];
        areas[f] = 0.25 * std::sqrt(std::max(0.0, sixteen_squared_areas(a, b, c)));
    }
    return areas;
}

/// A third of the areas around each vertex [length^2].
Eigen::VectorXd vertex_areas(const Topology& topology, const Eigen::VectorXd& areas)
{
    Eigen::VectorXd result = Eigen::VectorXd::Zero(topology.vertex_count());
    for (int f = 0; f < topology.face_count(); ++f)
        for (int c = 0; c < 3; ++c)
            result[topology.faces()(f, c)] += areas[f] / 3.0;
    return result;
}

/// Factors from the mesh to the sphere of that radius: those to the plane and those of the inverse
/// stereographic projection, 2 radius / (height (1 + |w|^2)) in lengths.
Eigen::VectorXd factors_on_sphere(const FlatMetric& flat, const StereographicFrame& frame,
                                  int infinite_vertex, double radius)
{
    Eigen::VectorXd factors = flat.u;
    const double shift = std::log(2.0 * radius / frame.height);
    for (int v = 0; v < factors.size(); ++v) {
        const double distance = std::abs(flat.layout.positions[v] - frame.centre) / frame.height;
        factors[v] += shift - 2.0 * std::log(std::hypot(1.0, distance));
    }
    // The chord from infinity to w is 2 radius / sqrt(1 + |w|^2); all its edges give the same.
    const IntrinsicTriangulation& t = flat.triangulation;
    double sum = 0.0;
    for (const int h : flat.boundary) {
        const int v = t.source(h);
        const double distance = std::abs(flat.layout.positions[v] - frame.centre) / frame.height;
        const int spoke = t.edge(Topology::next(t.opposite(h))); // v to infinity
        sum += 2.0 * (std::log(2.0 * radius / std::hypot(1.0, distance)) - t.log_lengths()[spoke]) -
               factors[v];
    }
    factors[infinite_vertex] = sum / static_cast<double>(flat.boundary.size());
    return factors;
}

std::vector<int> find_reversed_faces(const Topology& topology, const SpherePoints& sphere)
{
    std::vector<int> reversed;
    for (int f = 0; f < topology.face_count(); ++f) {
        const Eigen::RowVector3i v = topology.faces().row(f);
        const Eigen::RowVector3d normal =
            sphere.difference(v[0], v[1]).cross(sphere.difference(v[0], v[2]));
        if (sphere.points.row(v[0]).dot(normal) <= 0.0)
            reversed.push_back(f);
    }
    return reversed;
}

ConformalCertificate certify(const SphereMap& map, const FlatMetric& flat)
{
    // Negated, so that NaN fails.
    if (!flat.broken_faces.empty() || !(map.angle_residual <= 1e-9) || !(map.edges.worst <= 1e-9) ||
        !(map.balance_residual <= 1e-9))
        return ConformalCertificate::Unsolved;
    if (flat.all_released)
        return ConformalCertificate::Refined;
    if (!map.edges.flipped.empty())
        return ConformalCertificate::Repaired;
    return map.reversed_faces.empty() ? ConformalCertificate::Exact : ConformalCertificate::Folded;
}

} // namespace

std::string why_not_spherical(const Topology& topology)
{
    if (!topology.is_closed())
        return join("the mesh has ", counted(topology.boundary_loop_count(), "boundary loop"),
                    ", a conformal map to the sphere needs a closed surface; close "
                    "the holes, or flatten the mesh as a disc if it has one");
    if (topology.genus() > 0)
        return join("the mesh has genus ", topology.genus(),
                    ", a conformal map to the sphere needs genus 0; cut the handles and fill the "
                    "holes that this leaves");
    return {};
}

void check(const SphereMapOptions& options)
{
    require_at_least(-1, options.infinite_vertex, "SphereMapOptions.infinite_vertex");
    check(options.repair);
}

SphereMap map_to_sphere(const Topology& topology, const Eigen::VectorXd& lengths,
                        const SphereMapOptions& options)
{
    if (const std::string reason = why_not_spherical(topology); !reason.empty())
        throw InvalidInput(reason);
    check(options);
    const int vertex_count = topology.vertex_count();
    if (options.infinite_vertex >= vertex_count)
        throw InvalidInput(join("infinite_vertex is ", options.infinite_vertex,
                                ", must be in [-1, ", vertex_count - 1, "]"));
    IntrinsicTriangulation triangulation(topology, lengths);
    SphereMap map;
    map.infinite_vertex =
        options.infinite_vertex >= 0 ? options.infinite_vertex : central_vertex(topology, lengths);
    const FlatMetric flat =
        flatten_punctured_sphere(std::move(triangulation), map.infinite_vertex, options.repair);

    const Eigen::VectorXd areas = face_areas(topology, lengths);
    const MoebiusBalance balance = balance_on_sphere(
        flat.layout.positions, vertex_areas(topology, areas), map.infinite_vertex);
    map.radius = std::sqrt(areas.sum() / (4.0 * std::numbers::pi));
    map.sphere = project_to_sphere(flat.layout, balance.frame, map.infinite_vertex);
    map.factors = factors_on_sphere(flat, balance.frame, map.infinite_vertex, map.radius);
    map.angle_residual = flat.angle_residual;
    map.balance_residual = balance.residual;
    map.newton_steps = flat.newton_steps;
    map.repair_rounds = flat.rounds;
    map.edges = measure_conformal_edges(
        topology, lengths, map.factors, flat.triangulation,
        [&](int a, int b) { return map.radius * map.sphere.difference(a, b).norm(); });
    map.reversed_faces = find_reversed_faces(topology, map.sphere);
    map.certificate = certify(map, flat);
    return map;
}

} // namespace shape
