// SPDX-License-Identifier: MIT

#include "libshape/registration/synthetic_scan.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <limits>
#include <queue>
#include <utility>
#include <vector>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/random.h"
#include "libshape/base/require.h"
#include "libshape/base/stop.h"
#include "libshape/base/to_size.h"
#include "libshape/mesh/vertex_normals.h"
#include "libshape/registration/closest_points.h"
#include "libshape/registration/editable_mesh.h"
#include "libshape/registration/scan_surface.h"

namespace shape {
using namespace internal;
namespace {

using Eigen::Vector3d;
using Mesh = EditableMesh;
using Vertex = Mesh::VertexHandle;

Vector3d at(const Mesh& mesh, Vertex v)
{
    const auto& p = mesh.point(v);
    return {p[0], p[1], p[2]};
}

double length_of(const Mesh& mesh, Mesh::EdgeHandle e)
{
    return mesh.calc_edge_length(e);
}

void split_long_edges(Mesh& mesh, double longest)
{
    constexpr int most_passes = 20; // each halves what is too long
    bool found = true;
    for (int pass = 0; found && pass < most_passes; ++pass) {
        found = false;
        const auto count = static_cast<int>(mesh.n_edges()); // those made here have their turn next
        for (int i = 0; i < count; ++i) {
            throw_if_stop_requested();
            const Mesh::EdgeHandle e(i);
            if (mesh.status(e).deleted() || length_of(mesh, e) <= longest)
                continue;
            (void)mesh.split(e, mesh.calc_edge_midpoint(e));
            found = true;
        }
    }
}

Vector3d normal_of(const Vector3d& a, const Vector3d& b, const Vector3d& c)
{
    return (b - a).cross(c - a);
}

/// Whether the faces around `from`, but those at `to`, keep their side and no edge gets too long.
bool may_move_to(const Mesh& mesh, Vertex from, Vertex to, double longest)
{
    const Vector3d there = at(mesh, to);
    for (const auto v : mesh.vv_range(from))
        if ((at(mesh, v) - there).norm() > longest)
            return false;
    for (const auto f : mesh.vf_range(from)) {
        std::vector<Vector3d> before, after;
        bool vanishes = false;
        for (const auto v : mesh.fv_range(f)) {
            vanishes = vanishes || v == to;
            before.push_back(at(mesh, v));
            after.push_back(v == from ? there : before.back());
        }
        const Vector3d old_normal = normal_of(before[0], before[1], before[2]);
        const Vector3d new_normal = normal_of(after[0], after[1], after[2]);
        if (!vanishes && old_normal.dot(new_normal) <= 0.5 * old_normal.norm() * new_normal.norm())
            return false;
    }
    return true;
}

void collapse_short_edges(Mesh& mesh, double shortest, double longest)
{
    for (int i = 0; i < static_cast<int>(mesh.n_edges()); ++i) {
        throw_if_stop_requested();
        const Mesh::EdgeHandle e(i);
        if (mesh.status(e).deleted() || length_of(mesh, e) >= shortest)
            continue;
        for (const unsigned side : {0U, 1U}) {
            const auto h = mesh.halfedge_handle(e, side);
            const Vertex from = mesh.from_vertex_handle(h), to = mesh.to_vertex_handle(h);
            if (mesh.is_boundary(from) && !mesh.is_boundary(e))
                continue; // a rim stays a rim
            if (mesh.is_collapse_ok(h) && may_move_to(mesh, from, to, longest)) {
                mesh.collapse(h);
                break;
            }
        }
    }
    mesh.garbage_collection();
}

/// Flips edges where valences come nearer to six (four at rims).
void even_out_valences(Mesh& mesh)
{
    const auto excess = [&](Vertex v, int change) {
        return std::abs(static_cast<int>(mesh.valence(v)) + change - (mesh.is_boundary(v) ? 4 : 6));
    };
    for (int i = 0; i < static_cast<int>(mesh.n_edges()); ++i) {
        throw_if_stop_requested();
        const Mesh::EdgeHandle e(i);
        if (mesh.is_boundary(e) || !mesh.is_flip_ok(e))
            continue;
        const auto h = mesh.halfedge_handle(e, 0), g = mesh.halfedge_handle(e, 1);
        const Vertex a = mesh.from_vertex_handle(h), b = mesh.to_vertex_handle(h);
        const Vertex c = mesh.to_vertex_handle(mesh.next_halfedge_handle(h));
        const Vertex d = mesh.to_vertex_handle(mesh.next_halfedge_handle(g));
        if (excess(a, -1) + excess(b, -1) + excess(c, 1) + excess(d, 1) >=
            excess(a, 0) + excess(b, 0) + excess(c, 0) + excess(d, 0))
            continue;
        const Vector3d pa = at(mesh, a), pb = at(mesh, b), pc = at(mesh, c), pd = at(mesh, d);
        const Vector3d before = normal_of(pa, pb, pc) + normal_of(pb, pa, pd);
        const Vector3d one = normal_of(pc, pd, pb), other = normal_of(pd, pc, pa);
        const double least = 0.5 * before.norm();
        if (one.dot(before) > least * one.norm() && other.dot(before) > least * other.norm())
            mesh.flip(e);
    }
}

/// Inner vertices go to the mean of their neighbours, shaken by `jitter`, and back onto the surface.
void relax(Mesh& mesh, const ClosestPoints& surface, double edge, double jitter, Random& random)
{
    mesh.update_normals();
    std::vector<Vector3d> moved;
    for (const auto v : mesh.vertices()) {
        throw_if_stop_requested();
        const Vector3d here = at(mesh, v);
        moved.push_back(here);
        if (mesh.is_boundary(v))
            continue;
        Vector3d mean = Vector3d::Zero();
        for (const auto other : mesh.vv_range(v))
            mean += at(mesh, other) / static_cast<double>(mesh.valence(v));
        const auto& n = mesh.normal(v);
        const Vector3d normal(n[0], n[1], n[2]);
        mean += jitter * Vector3d(random.normal(), random.normal(), random.normal());
        NearestRule rule;
        rule.within = 0.5 * edge; // farther off is another sheet
        rule.normal = normal;
        rule.least_cosine = 0.0;
        const SurfacePoint point = surface.nearest(mean - normal.dot(mean - here) * normal, rule);
        if (point.face >= 0)
            moved.back() = point.position;
    }
    for (const auto v : mesh.vertices()) {
        const Vector3d& p = moved[to_size(v.idx())];
        mesh.set_point(v, {p[0], p[1], p[2]});
    }
}

/// The surface with about so many vertices.
Scan remeshed(const Topology& topology, const Points& points, int vertex_count, Random& random)
{
    Mesh mesh = editable_mesh(topology, points);
    mesh.request_vertex_normals();
    double area = 0.0;
    for (const auto& face : topology.faces().rowwise())
        area +=
            0.5 * normal_of(points.row(face[0]), points.row(face[1]), points.row(face[2])).norm();
    const ClosestPoints surface(points, topology.faces());
    // 2 V faces of side h, sqrt(3) / 4 h^2 each; splitting at 4/3 and collapsing at 4/5 (Botsch, Kobbelt 2004) leave
    // edges shorter than h on average, by as much as 1.07 makes up for.
    const double edge = 1.07 * std::sqrt(area / (0.5 * std::sqrt(3.0) * vertex_count));
    constexpr int rounds = 6;
    for (int round = 0; round < rounds; ++round) {
        split_long_edges(mesh, 4.0 / 3.0 * edge);
        collapse_short_edges(mesh, 4.0 / 5.0 * edge, 4.0 / 3.0 * edge);
        even_out_valences(mesh);
        // Perturbed once, so that no vertex stays where the template has one.
        relax(mesh, surface, edge, round == 0 ? 0.3 * edge : 0.0, random);
    }
    mesh.garbage_collection();

    Points new_points(static_cast<Eigen::Index>(mesh.n_vertices()), 3);
    for (const auto v : mesh.vertices())
        new_points.row(v.idx()) = at(mesh, v);
    Faces faces(static_cast<Eigen::Index>(mesh.n_faces()), 3);
    for (const auto f : mesh.faces()) {
        int k = 0;
        for (const auto v : mesh.fv_range(f))
            faces(f.idx(), k++) = v.idx();
    }
    return clean_scan(new_points, faces);
}

/// Without the vertices that are marked, and their faces.
Scan without(const Scan& scan, const std::vector<char>& gone)
{
    std::vector<int> kept;
    for (int f = 0; f < scan.faces.rows(); ++f)
        if (gone[to_size(scan.faces(f, 0))] + gone[to_size(scan.faces(f, 1))] +
                gone[to_size(scan.faces(f, 2))] ==
            0)
            kept.push_back(f);
    return clean_scan(scan.points, scan.faces(kept, Eigen::all));
}

void add_noise(Scan& scan, double noise, Random& random)
{
    double sum = 0.0;
    for (const auto& face : scan.faces.rowwise())
        sum += (scan.points.row(face[1]) - scan.points.row(face[0])).norm();
    const double deviation = noise * sum / static_cast<double>(scan.faces.rows());
    const Points normals = vertex_normals(scan.points, scan.faces);
    for (Eigen::Index v = 0; v < scan.points.rows(); ++v)
        scan.points.row(v) += deviation * random.normal() * normals.row(v);
}

/// Marks what lies beyond a plane of random direction.
void mark_cut(const Points& points, double share, Random& random, std::vector<char>& gone)
{
    const Vector3d normal =
        Vector3d(random.normal(), random.normal(), random.normal()).stableNormalized();
    const Eigen::VectorXd heights = points * normal;
    std::vector<double> sorted(heights.begin(), heights.end());
    const auto at = sorted.begin() + static_cast<std::ptrdiff_t>(
                                         (1.0 - share) * static_cast<double>(sorted.size() - 1));
    std::nth_element(sorted.begin(), at, sorted.end());
    for (std::size_t v = 0; v < gone.size(); ++v)
        if (heights[static_cast<Eigen::Index>(v)] > *at)
            gone[v] = 1;
}

} // namespace

void check(const SyntheticScanOptions& options)
{
    require(options.vertices == 0 || options.vertices >= 50, "SyntheticScanOptions.vertices",
            options.vertices, "0 or >= 50");
    require_not_negative(options.noise, "SyntheticScanOptions.noise");
    require(options.holes >= 0, "SyntheticScanOptions.holes", options.holes, ">= 0");
    require_positive(options.hole_radius, "SyntheticScanOptions.hole_radius");
    require(options.cut >= 0.0 && options.cut <= 0.9, "SyntheticScanOptions.cut", options.cut,
            "in [0, 0.9]");
}

Scan synthetic_scan(const Topology& topology, const Points& points,
                    const SyntheticScanOptions& options)
{
    check(options);
    Random random(options.seed);
    Scan scan = remeshed(topology, points,
                         options.vertices > 0 ? options.vertices : topology.vertex_count(), random);
    if (options.noise > 0.0)
        add_noise(scan, options.noise, random);
    std::vector<char> gone(to_size(scan.points.rows()), 0);
    if (options.cut > 0.0)
        mark_cut(scan.points, options.cut, random, gone);
    const double radius = options.hole_radius * bounding_box_diagonal(points);
    for (int hole = 0; hole < options.holes; ++hole) {
        const auto centre = static_cast<Eigen::Index>(random.index(gone.size()));
        for (std::size_t v = 0; v < gone.size(); ++v)
            if ((scan.points.row(static_cast<Eigen::Index>(v)) - scan.points.row(centre)).norm() <
                radius)
                gone[v] = 1;
    }
    return without(scan, gone);
}

std::vector<int> spread_vertices(const Topology& topology, const Points& points, int count)
{
    if (count < 1 || count > topology.vertex_count())
        throw InvalidInput(join("spread_vertices: count is ", count, ", must be in [1, ",
                                topology.vertex_count(), "]"));
    std::vector<double> distance(to_size(topology.vertex_count()),
                                 std::numeric_limits<double>::infinity());
    using Entry = std::pair<double, int>;
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
    const auto start_at = [&](int v) {
        distance[to_size(v)] = 0.0;
        queue.emplace(0.0, v);
    };
    for (int v = 0; v < topology.vertex_count(); ++v)
        if (topology.is_boundary_vertex(v))
            start_at(v);
    std::vector<int> chosen;
    if (queue.empty()) {
        const Eigen::RowVector3d centroid = points.colwise().mean();
        int farthest = 0;
        (void)(points.rowwise() - centroid).rowwise().squaredNorm().maxCoeff(&farthest);
        chosen.push_back(farthest);
        start_at(farthest);
    }
    for (;;) {
        while (!queue.empty()) {
            const auto [d, v] = queue.top();
            queue.pop();
            if (d > distance[to_size(v)])
                continue;
            for (const Topology::Spoke& spoke : topology.spokes(v)) {
                const double next = d + (points.row(v) - points.row(spoke.vertex)).norm();
                if (next < distance[to_size(spoke.vertex)]) {
                    distance[to_size(spoke.vertex)] = next;
                    queue.emplace(next, spoke.vertex);
                }
            }
        }
        if (std::ssize(chosen) == count)
            return chosen;
        const auto farthest = std::max_element(distance.begin(), distance.end());
        chosen.push_back(static_cast<int>(farthest - distance.begin()));
        start_at(chosen.back());
    }
}

} // namespace shape
