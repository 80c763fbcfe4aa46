// SPDX-License-Identifier: MIT

#include "libshape/embedding/fold_repair.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <unordered_map>
#include <utility>

#include "libshape/base/random.h"
#include "libshape/base/threads.h"
#include "libshape/embedding/gauss_newton.h"
#include "libshape/mesh/alignment.h"
#include "libshape/mesh/dihedral_angles.h"

namespace shape {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;

/// Vertices of suspect wedges, grown by rings, as connected regions in ascending order; those with a
/// fold.
std::vector<std::vector<int>> folded_regions(const LengthDihedralEnergy& energy,
                                             const VectorXd& points,
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

    struct Region
    {
        std::vector<int> vertices;
        bool folded = false;
    };
    std::vector<std::vector<int>> regions;
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
        if (region.folded)
            regions.push_back(std::move(region.vertices));
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

/// The region's vertices moved at random along their normals, by up to half the edges around them.
VectorXd shaken(const Topology& t, const std::vector<int>& vertices, std::uint64_t seed,
                VectorXd points)
{
    Random random(seed);
    const VectorXd before = points;
    for (const int v : vertices) {
        Vector3d normal = Vector3d::Zero();
        double lengths = 0.0;
        for (const int h : t.outgoing(v)) {
            const Vector3d centre = before.segment<3>(3 * v);
            const Vector3d a = before.segment<3>(3 * t.target(h)) - centre;
            const Vector3d b = before.segment<3>(3 * t.source(Topology::previous(h))) - centre;
            normal += a.cross(b);
            lengths += a.norm();
        }
        const double reach = 0.5 * lengths / static_cast<double>(t.outgoing(v).size());
        points.segment<3>(3 * v) += random.uniform(-reach, reach) * normal.stableNormalized();
    }
    return points;
}

} // namespace

FoldRepair repair_folds(const LengthDihedralEnergy& energy, const std::vector<Points>& references,
                        VectorXd points, const FoldRepairOptions& options)
{
    FoldRepair repair{std::move(points), 0, 0};
    const Topology& topology = energy.topology();
    for (const std::vector<int>& vertices : folded_regions(energy, repair.points, options)) {
        if (vertices.size() > static_cast<std::size_t>(options.largest_region) ||
            vertices.size() == static_cast<std::size_t>(topology.vertex_count()))
            continue;
        ++repair.regions;
        const GaussNewton region(topology, vertices);
        const auto start = [&](std::size_t k) -> VectorXd {
            if (k == 0)
                return repair.points;
            if (k <= references.size())
                return rigid_filling(region, energy, references[k - 1], repair.points);
            return shaken(topology, vertices, k - references.size(), repair.points);
        };
        std::vector<GaussNewtonResult> candidates(1 + references.size() +
                                                  static_cast<std::size_t>(options.shaken_starts));
        constexpr double tolerance = 1e-2;
        parallel_for(candidates.size(), 1, [&](std::size_t k, std::size_t) {
            candidates[k] = region.minimize(
                energy, start(k),
                {.max_iterations = options.trial_iterations, .decrease_tolerance = tolerance});
        });
        std::vector<std::size_t> order(candidates.size());
        std::iota(order.begin(), order.end(), std::size_t{0});
        const auto by_value = [&](std::size_t a, std::size_t b) {
            return std::pair(candidates[a].value, a) < std::pair(candidates[b].value, b);
        };
        constexpr std::size_t finalists = 3;
        std::sort(order.begin(), order.end(), by_value);
        order.resize(std::min(order.size(), finalists));
        parallel_for(order.size(), 1, [&](std::size_t k, std::size_t) {
            GaussNewtonResult& candidate = candidates[order[k]];
            if (!candidate.converged)
                candidate = region.minimize(
                    energy, candidate.points,
                    {.max_iterations = options.final_iterations, .decrease_tolerance = tolerance});
        });
        const std::size_t best = *std::min_element(order.begin(), order.end(), by_value);
        if (best != 0)
            ++repair.replaced;
        repair.points = candidates[best].points;
    }
    return repair;
}

} // namespace shape
