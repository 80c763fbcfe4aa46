// SPDX-License-Identifier: MIT

#include "libshape/embedding/repair/region_repair.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>
#include <optional>
#include <utility>

#include "libshape/base/random.h"
#include "libshape/base/require.h"
#include "libshape/base/threads.h"
#include "libshape/base/to_size.h"
#include "libshape/embedding/energy/stretch_term.h"
#include "libshape/embedding/repair/rigid_filling.h"
#include "libshape/mesh/alignment.h"
#include "libshape/mesh/dihedral_angles.h"
#include "libshape/mesh/hinge.h"

namespace shape::internal {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;

/// Vertices [0, count) of a region, of a mesh row by row.
Points gathered(const RegionMesh& region, int count, const double* mesh)
{
    Points points(count, 3);
    for (int v = 0; v < count; ++v)
        points.row(v) =
            Eigen::Map<const Eigen::RowVector3d>(mesh + 3 * region.vertices[to_size(v)]);
    return points;
}

/// The inverse of gathered().
void scatter(const RegionMesh& region, const Points& points, double* mesh)
{
    for (int v = 0; v < points.rows(); ++v)
        Eigen::Map<Eigen::RowVector3d>(mesh + 3 * region.vertices[to_size(v)]) = points.row(v);
}

void set_lane(const Points& from, int lane, EightLanePoints& to)
{
    for (std::size_t v = 0; v < to.size(); ++v) {
        const auto row = from.row(static_cast<Eigen::Index>(v)).cast<float>();
        to[v].x.of[lane] = row[0];
        to[v].y.of[lane] = row[1];
        to[v].z.of[lane] = row[2];
    }
}

Points lane_of(const EightLanePoints& from, int lane, int count)
{
    Points points(count, 3);
    for (int v = 0; v < count; ++v) {
        const EightLanePoint& p = from[to_size(v)];
        points.row(v) << p.x.of[lane], p.y.of[lane], p.z.of[lane];
    }
    return points;
}

/// The Laplacian of the moving vertices, weighted by 1 / lengths^2.
SparseMatrix laplacian(const RegionMesh& region, const std::vector<float>& lengths)
{
    std::vector<Eigen::Triplet<double>> entries;
    for (std::size_t e = 0; e < lengths.size(); ++e) {
        const double weight = 1.0 / (lengths[e] * lengths[e]);
        const int a = region.ends[2 * e];
        const int b = region.ends[2 * e + 1];
        for (const int end : {a, b})
            if (end < region.moving_vertices)
                entries.emplace_back(end, end, weight);
        if (std::max(a, b) < region.moving_vertices)
            entries.emplace_back(std::max(a, b), std::min(a, b), -weight);
    }
    SparseMatrix matrix(region.moving_vertices, region.moving_vertices);
    matrix.setFromTriplets(entries.begin(), entries.end());
    return matrix;
}

/// Vertices moved at random along their normals, by up to half the edges around them.
Points perturbed(const RegionMesh& region, std::uint64_t seed, const Points& before)
{
    Random random(seed);
    Points points = before;
    for (int v = 0; v < region.moving_vertices; ++v) {
        Vector3d normal = Vector3d::Zero();
        double lengths = 0.0;
        const int begin = region.halfedge_begins[to_size(v)];
        const int end = region.halfedge_begins[to_size(v) + 1];
        for (int i = begin; i < end; ++i) {
            const int h = region.halfedges[to_size(i)];
            const auto from_vertex = [&](int halfedge) -> Vector3d {
                return before.row(region.corners[to_size(halfedge)]) - before.row(v);
            };
            const Vector3d a = from_vertex(Topology::next(h));
            normal += a.cross(from_vertex(Topology::previous(h)));
            lengths += a.norm();
        }
        const double reach = 0.5 * lengths / (end - begin);
        points.row(v) += random.uniform(-reach, reach) * normal.stableNormalized().transpose();
    }
    return points;
}

/// Terms of E that a region takes part in.
double energy_of(const LengthDihedralEnergy& energy, const RegionMesh& region,
                 const VectorXd& points)
{
    const Topology& t = energy.topology();
    const auto point = [&](int v) -> Vector3d { return points.segment<3>(3 * v); };
    double sum = 0.0;
    for (const int e : region.edges) {
        const auto [from, to, left, right] = hinge_corners(t, e);
        const Vector3d a = point(from);
        const Vector3d b = point(to);
        sum += stretch_term((b - a).norm() / energy.target().edge_lengths[e] - 1.0).value;
        if (right < 0)
            continue;
        const double angle = dihedral_angle(a, b, point(left), point(right));
        const double bend = wrapped_angle(angle - energy.target().dihedral_angles[e]);
        sum += energy.bend_weights()[e] * bend * bend;
    }
    return sum;
}

/// A region and where its moving vertices come to lie.
struct Repaired
{
    RegionMesh region;
    Points points;
};

/// The lowest of all starts.
Repaired repaired(const LengthDihedralEnergy& energy, const std::vector<Points>& references,
                  const VectorXd& points, const std::vector<int>& vertices,
                  const RegionRepairOptions& options)
{
    const RegionMesh region(energy.topology(), vertices);
    EightLaneEnergy lanes(energy, region);
    const double unit = lanes.unit();
    std::vector<float> lengths;
    for (const int e : region.edges)
        lengths.push_back(static_cast<float>(energy.target().edge_lengths[e] / unit));
    const EightLaneSolve solve(laplacian(region, lengths));

    Points present = gathered(region, region.vertex_count(), points.data());
    const Eigen::RowVector3d centre = present.colwise().mean();
    present = (present.rowwise() - centre) / unit;
    const auto turned_reference = [&](const Points& mesh) -> Points {
        const Points reference = gathered(region, region.vertex_count(), mesh.data()) / unit;
        const Eigen::Index held = region.vertex_count() - region.moving_vertices;
        return best_rigid_motion(reference.bottomRows(held), present.bottomRows(held))(reference);
    };

    // Start 0 is the region as it is, then come references, then random perturbations.
    const std::size_t starts = 1 + references.size() + to_size(options.perturbed_starts);
    Repaired best{region, {}};
    float least = std::numeric_limits<float>::infinity();
    for (std::size_t first = 0; first < starts; first += EightLanes::lanes) {
        EightLanePoints eight(region.vertices.size());
        for (int lane = 0; lane < EightLanes::lanes; ++lane)
            set_lane(present, lane, eight);
        if (first <= references.size()) {
            EightLanePoints bent = eight;
            for (int lane = 0; lane < EightLanes::lanes; ++lane)
                if (const std::size_t start = first + to_size(lane);
                    start >= 1 && start <= references.size())
                    set_lane(turned_reference(references[start - 1]), lane, bent);
            fill_rigidly(region, lengths, solve, bent, options.filling_sweeps, eight);
        }
        for (int lane = 0; lane < EightLanes::lanes; ++lane) {
            const std::size_t start = first + to_size(lane);
            if (start == 0)
                set_lane(present, lane, eight);
            else if (start > references.size())
                set_lane(perturbed(region, start - references.size(), present), lane, eight);
        }
        const auto energies = descend(lanes, solve, eight, options.descent);
        for (int lane = 0; lane < EightLanes::lanes; ++lane)
            if (const float value = energies[to_size(lane)]; value < least) {
                least = value;
                best.points = lane_of(eight, lane, region.moving_vertices);
            }
    }
    best.points = (unit * best.points).rowwise() + centre;
    return best;
}

} // namespace

void check(const RegionRepairOptions& options)
{
    require_at_least(0, options.largest_region, "RegionRepairOptions.largest_region");
    require_at_least(0, options.filling_sweeps, "RegionRepairOptions.filling_sweeps");
    require_at_least(0, options.perturbed_starts, "RegionRepairOptions.perturbed_starts");
    check(options.descent);
}

RegionRepair repair_regions(const LengthDihedralEnergy& energy,
                            const std::vector<Points>& references, VectorXd points,
                            std::vector<std::vector<int>> regions,
                            const RegionRepairOptions& options)
{
    check(options);
    RegionRepair repair{std::move(points), 0, 0.0};
    std::erase_if(regions, [&](const std::vector<int>& vertices) {
        return vertices.size() > to_size(options.largest_region) ||
               vertices.size() == to_size(energy.topology().vertex_count());
    });
    std::vector<std::optional<Repaired>> results(regions.size());
    parallel_for(regions.size(), 1, [&](std::size_t k, std::size_t) {
        results[k] = repaired(energy, references, repair.points, regions[k], options);
    });
    // Neighbouring regions share hinges, and single precision rounds: what counts is E as it is now.
    for (const auto& result : results) {
        const auto& [region, moved] = *result;
        double* const mesh = repair.points.data();
        const Points before = gathered(region, region.moving_vertices, mesh);
        const double energy_before = energy_of(energy, region, repair.points);
        scatter(region, moved, mesh);
        const double decrease = energy_before - energy_of(energy, region, repair.points);
        if (decrease > 0.0) {
            ++repair.replaced;
            repair.decrease += decrease;
        } else {
            scatter(region, before, mesh);
        }
    }
    return repair;
}

} // namespace shape::internal
