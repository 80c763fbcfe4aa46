// SPDX-License-Identifier: MIT

#include "libshape/embedding/fold_repair.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <unordered_map>
#include <utility>

#include "libshape/base/threads.h"
#include "libshape/embedding/gauss_newton.h"
#include "libshape/mesh/alignment.h"
#include "libshape/mesh/dihedral_angles.h"

namespace shape {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;

struct Region
{
    std::vector<int> vertices;
    bool folded = false;
};

/// Vertices of suspect wedges, grown by rings, as connected regions in ascending order.
std::vector<Region> suspect_regions(const LengthDihedralEnergy& energy, const VectorXd& points,
                                    const FoldRepairOptions& options)
{
    const Topology& t = energy.topology();
    const VectorXd angles =
        dihedral_angles(t, Eigen::Map<const Points>(points.data(), t.vertex_count(), 3));
    std::vector<char> marked(static_cast<std::size_t>(t.vertex_count()), 0);
    std::vector<char> folded(marked.size(), 0);
    std::vector<int> front;
    const auto mark = [&](int v) {
        if (!marked[static_cast<std::size_t>(v)]) {
            marked[static_cast<std::size_t>(v)] = 1;
            front.push_back(v);
        }
    };
    for (int e = 0; e < t.edge_count(); ++e) {
        const double drift =
            std::abs(wrapped_angle(angles[e] - energy.target().dihedral_angles[e]));
        if (t.is_boundary_edge(e) || drift <= options.suspect_angle)
            continue;
        for (const int h : {t.edge_halfedges()(e, 0), t.edge_halfedges()(e, 1)}) {
            mark(t.source(h));
            mark(t.source(Topology::previous(h)));
        }
        if (drift > options.fold_angle)
            folded[static_cast<std::size_t>(t.edges()(e, 0))] = 1;
    }
    const auto neighbours = [&](int v, const auto& visit) {
        for (const int h : t.outgoing(v)) {
            visit(t.target(h));
            visit(t.source(Topology::previous(h)));
        }
    };
    for (int ring = 0; ring < options.rings; ++ring)
        for (const int v : std::vector<int>(std::exchange(front, {})))
            neighbours(v, mark);

    std::vector<Region> regions;
    for (int v = 0; v < t.vertex_count(); ++v) {
        if (!marked[static_cast<std::size_t>(v)])
            continue;
        Region region;
        const auto take = [&](int w) {
            if (marked[static_cast<std::size_t>(w)]) {
                marked[static_cast<std::size_t>(w)] = 0;
                region.vertices.push_back(w);
                region.folded = region.folded || folded[static_cast<std::size_t>(w)] != 0;
            }
        };
        take(v);
        for (std::size_t i = 0; i < region.vertices.size(); ++i)
            neighbours(region.vertices[i], take);
        regions.push_back(std::move(region));
    }
    return regions;
}

/// The region as the reference bent into its surroundings as rigidly as possible: from the harmonic
/// filling, alternates rotations per vertex and positions.
VectorXd rigid_filling(const GaussNewton& region, const LengthDihedralEnergy& energy,
                       const Points& reference, VectorXd points)
{
    const Topology& t = energy.topology();
    const VectorXd& lengths = energy.target().edge_lengths;
    const auto point = [&](int v) -> Vector3d { return points.segment<3>(3 * v); };
    const auto reference_vector = [&](int from, int to) -> Vector3d {
        return (reference.row(to) - reference.row(from)).transpose();
    };

    std::unordered_map<int, Eigen::Index> row;
    for (const int v : region.vertices())
        row.emplace(v, static_cast<Eigen::Index>(row.size()));
    const auto size = static_cast<Eigen::Index>(row.size());
    Eigen::MatrixXd laplacian = Eigen::MatrixXd::Zero(size, size);
    std::vector<int> around; // region and its rim
    for (const int e : region.edges()) {
        const double weight = 1.0 / (lengths[e] * lengths[e]);
        const auto a = row.find(t.edges()(e, 0));
        const auto b = row.find(t.edges()(e, 1));
        for (const auto& end : {a, b})
            if (end != row.end())
                laplacian(end->second, end->second) += weight;
        if (a != row.end() && b != row.end()) {
            laplacian(a->second, b->second) -= weight;
            laplacian(b->second, a->second) -= weight;
        }
        around.push_back(t.edges()(e, 0));
        around.push_back(t.edges()(e, 1));
    }
    std::sort(around.begin(), around.end());
    around.erase(std::unique(around.begin(), around.end()), around.end());
    const Eigen::LLT<Eigen::MatrixXd> factor(laplacian);

    std::unordered_map<int, Matrix3d> rotation;
    const auto solve = [&](bool harmonic) {
        Eigen::MatrixXd rhs = Eigen::MatrixXd::Zero(size, 3);
        for (const int e : region.edges()) {
            const double weight = 1.0 / (lengths[e] * lengths[e]);
            const int a = t.edges()(e, 0);
            const int b = t.edges()(e, 1);
            Vector3d wanted = Vector3d::Zero(); // x_b - x_a
            if (!harmonic) {
                const Vector3d u = reference_vector(a, b);
                wanted = 0.5 * lengths[e] / u.norm() * ((rotation[a] + rotation[b]) * u);
            }
            const auto pull = [&](int v, int other, const Vector3d& offset) {
                const auto found = row.find(v);
                if (found == row.end())
                    return;
                rhs.row(found->second) += weight * offset.transpose();
                if (!row.contains(other))
                    rhs.row(found->second) += weight * point(other).transpose();
            };
            pull(a, b, -wanted);
            pull(b, a, wanted);
        }
        const Eigen::MatrixXd solution = factor.solve(rhs);
        for (const auto& [v, i] : row)
            points.segment<3>(3 * v) = solution.row(i).transpose();
    };
    solve(true);
    constexpr int sweeps = 15;
    for (int sweep = 0; sweep < sweeps; ++sweep) {
        for (const int v : around) {
            // Normals say which side is up: counted on the rim, where the surface is as wanted.
            Matrix3d covariance = Matrix3d::Zero();
            const bool rim = !row.contains(v);
            for (const int h : t.outgoing(v)) {
                const int a = t.target(h);
                const int b = t.source(Topology::previous(h));
                const Vector3d ua = reference_vector(v, a);
                const Vector3d ub = reference_vector(v, b);
                const Vector3d xa = point(a) - point(v);
                const Vector3d xb = point(b) - point(v);
                covariance += xa * ua.transpose() / ua.squaredNorm();
                if (rim)
                    covariance += xa.cross(xb).normalized() * ua.cross(ub).normalized().transpose();
            }
            rotation[v] = nearest_rotation(covariance);
        }
        solve(false);
    }
    return points;
}

} // namespace

FoldRepair repair_folds(const LengthDihedralEnergy& energy, const std::vector<Points>& references,
                        VectorXd points, const FoldRepairOptions& options)
{
    FoldRepair repair{std::move(points), 0, 0};
    for (const Region& suspect : suspect_regions(energy, repair.points, options)) {
        const std::size_t size = suspect.vertices.size();
        if (size > static_cast<std::size_t>(options.largest_region) ||
            size == static_cast<std::size_t>(energy.topology().vertex_count()))
            continue;
        ++repair.regions;
        const GaussNewton region(energy.topology(), suspect.vertices);
        std::vector<GaussNewtonResult> candidates(suspect.folded ? 1 + references.size() : 1);
        parallel_for(candidates.size(), 1, [&](std::size_t begin, std::size_t) {
            const VectorXd start =
                begin == 0 ? repair.points
                           : rigid_filling(region, energy, references[begin - 1], repair.points);
            candidates[begin] = region.minimize(
                energy, start,
                {.max_iterations = options.max_iterations, .decrease_tolerance = 1e-2});
        });
        const auto best =
            std::min_element(candidates.begin(), candidates.end(),
                             [](const auto& a, const auto& b) { return a.value < b.value; });
        if (best != candidates.begin())
            ++repair.replaced;
        repair.points = best->points;
    }
    return repair;
}

} // namespace shape
