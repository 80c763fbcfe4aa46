// SPDX-License-Identifier: MIT

#include "libshape/embedding/path/continuation.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/require.h"
#include "libshape/base/to_size.h"
#include "libshape/embedding/energy/gauss_newton.h"
#include "libshape/embedding/energy/graded_unknowns.h"
#include "libshape/embedding/energy/length_dihedral_energy.h"
#include "libshape/embedding/energy/stretch_term.h"
#include "libshape/embedding/start/face_fit.h"
#include "libshape/embedding/start/face_layout.h"
#include "libshape/linalg/sparse_cholesky.h"
#include "libshape/mesh/alignment.h"
#include "libshape/mesh/dihedral_angles.h"
#include "libshape/mesh/edge_lengths.h"
#include "libshape/mesh/vertex_regions.h"

namespace shape {
using namespace internal;
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;

/// Positions whose edges are nearest, relative to their lengths, to what the faces want.
class GradedLaplacian
{
public:
    GradedLaplacian(const Topology& topology, GradedUnknowns unknowns)
        : topology_(topology), unknowns_(std::move(unknowns))
    {
        for (int e = 0; e < topology_.edge_count(); ++e) {
            std::map<int, int> signs; // an unknown that moves both ends changes nothing
            for (const int end : {0, 1})
                for (const int row : unknowns_.rows[to_size(topology_.edges()(e, end))])
                    signs[row] += end == 0 ? -1 : 1;
            std::erase_if(signs, [](const auto& part) { return part.second == 0; });
            parts_.emplace_back(signs.begin(), signs.end());
        }
    }

    void set_lengths(const VectorXd& lengths)
    {
        weights_ = lengths.array().square().inverse();
        std::vector<Eigen::Triplet<double, int>> entries;
        for (int e = 0; e < topology_.edge_count(); ++e) {
            const double weight = (topology_.is_boundary_edge(e) ? 1.0 : 2.0) * weights_[e];
            for (const auto& [i, a] : parts_[to_size(e)])
                for (const auto& [j, b] : parts_[to_size(e)])
                    if (i >= j)
                        entries.emplace_back(i, j, a * b * weight);
        }
        const auto size = static_cast<Eigen::Index>(unknowns_.vertices.size());
        SparseMatrix matrix(size, size);
        matrix.setFromTriplets(entries.begin(), entries.end());
        if (factor_)
            factor_->refactor(matrix);
        else
            factor_.emplace(matrix);
    }

    /// Of set_lengths(): the weight of every edge.
    [[nodiscard]] const VectorXd& weights() const { return weights_; }

    [[nodiscard]] Points positions(const FaceLayout& layout, const Rotations& frames) const
    {
        Eigen::MatrixXd rhs =
            Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(unknowns_.vertices.size()), 3);
        for (int f = 0; f < topology_.face_count(); ++f) {
            const Matrix3d frame = frames[to_size(f)].toRotationMatrix();
            for (int h = 3 * f; h < 3 * f + 3; ++h) {
                const int e = topology_.edge(h);
                const double forward = topology_.source(h) == topology_.edges()(e, 0) ? 1.0 : -1.0;
                const Vector3d pull =
                    forward * weights_[e] * (frame.leftCols<2>() * layout.halfedge(h));
                for (const auto& [row, sign] : parts_[to_size(e)])
                    rhs.row(row) += sign * pull.transpose();
            }
        }
        const Eigen::MatrixXd solution = factor_->solve(rhs);
        Points points = Points::Zero(topology_.vertex_count(), 3);
        for (std::size_t v = 0; v < unknowns_.rows.size(); ++v)
            for (const int row : unknowns_.rows[v])
                points.row(static_cast<Eigen::Index>(v)) += solution.row(row);
        return points;
    }

private:
    Topology topology_;
    GradedUnknowns unknowns_;
    std::vector<std::vector<std::pair<int, int>>> parts_; // of an edge: unknowns and their signs
    VectorXd weights_;
    std::optional<SparseCholesky> factor_;
};

/// @throws InvalidInput if there is not a positive length for every edge.
void check_lengths(const Topology& topology, const VectorXd& lengths)
{
    if (lengths.size() != topology.edge_count() || !(lengths.array() > 0.0).all() ||
        !lengths.allFinite())
        throw InvalidInput(join("lengths: ", lengths.size(), " values for ", topology.edge_count(),
                                " edges, must be one each, > 0 and finite"));
}

// settle(): chosen on a femur, a head and a body on their ways to spheres (docs/experiments/conformal.md).

/// Regions are moved alone if fewer edges than this part are off: what more of them lack is not local, and
/// held surroundings would keep it.
constexpr double few_edges = 5e-3;
/// And if they have at most this part of the vertices; else a step of the whole mesh costs little more.
constexpr double local_part = 0.4;
/// Rings around edges that are off, in the first round of regions and more of them in each further one: what is
/// off is spread over as many edges as that takes.
constexpr int first_rings = 5;
constexpr int more_rings = 3;
/// Edges that are off by more than this part of the tolerance are seeds of regions, else their neighbours would
/// be the next.
constexpr double seed_part = 0.75;
/// A region takes this many Gauss-Newton steps at most; it costs little beside the whole mesh.
constexpr int region_steps = 3;
/// Angles weigh this part in regions: what is left to do there when all else fits is the hardest.
constexpr double region_smoothness = 0.1;

/// After so many rounds of single steps it starts again, with rounds that each end at a minimum: they cost
/// more steps and get past where a mesh is about to snap, at which single steps end up.
constexpr int quick_rounds = 8;
constexpr int thorough_steps = 12;

/// The weight of angles after a round of which a part of the step was taken (last_step): a shorter step is
/// what larger weights make, in a better direction.
double next_smoothness(double smoothness, double part)
{
    return part == 1.0 ? 0.3 * smoothness : part >= 0.5 ? smoothness : 3.0 * smoothness;
}

/// Unknowns of some vertices, each moved on its own.
GradedUnknowns unknowns_of(const Topology& topology, const std::vector<int>& vertices)
{
    GradedUnknowns unknowns{vertices,
                            std::vector<std::vector<int>>(to_size(topology.vertex_count()))};
    std::sort(unknowns.vertices.begin(), unknowns.vertices.end());
    for (std::size_t row = 0; row < vertices.size(); ++row)
        unknowns.rows[to_size(unknowns.vertices[row])].push_back(static_cast<int>(row));
    return unknowns;
}

/// Ends of edges whose value is above a bound.
std::vector<int> ends_above(const Topology& topology, const VectorXd& values, double bound)
{
    std::vector<int> ends;
    for (int e = 0; e < topology.edge_count(); ++e)
        if (values[e] > bound)
            ends.insert(ends.end(), {topology.edges()(e, 0), topology.edges()(e, 1)});
    return ends;
}

/// The regions around edges that are off if these are few, and the regions a small part of the mesh; else none.
/// @param errors  #E, relative.
std::vector<std::vector<int>> few_regions(const Topology& topology, const VectorXd& errors,
                                          double tolerance, int rings)
{
    if (static_cast<double>((errors.array() > tolerance).count()) >
        few_edges * topology.edge_count())
        return {};
    std::vector<std::vector<int>> regions =
        regions_around(topology, ends_above(topology, errors, seed_part * tolerance), rings);
    std::size_t size = 0;
    for (const std::vector<int>& region : regions)
        size += region.size();
    if (static_cast<double>(size) > local_part * topology.vertex_count())
        return {};
    return regions;
}

} // namespace

void check(const SettlingOptions& options)
{
    require_positive(options.smoothness, "SettlingOptions.smoothness");
    require_positive(options.stiffness, "SettlingOptions.stiffness");
    require_not_negative(options.edge_tolerance, "SettlingOptions.edge_tolerance");
    require_at_least(0, options.rounds, "SettlingOptions.rounds");
}

void check(const ContinuationOptions& options)
{
    require_positive(options.smoothness, "ContinuationOptions.smoothness");
    require_positive(options.stiffness, "ContinuationOptions.stiffness");
    require_not_negative(options.decrease_tolerance, "ContinuationOptions.decrease_tolerance");
    require_at_least(0, options.max_iterations, "ContinuationOptions.max_iterations");
}

struct Continuation::State
{
    State(const Topology& of, const GradedUnknowns& unknowns)
        : topology(of), laplacian(of, unknowns), solver(of, unknowns)
    {
    }

    /// The mesh with the target's lengths and bending as far as Laplace solves can have them.
    Points linear_start(const Points& from, const ShapePoint& target)
    {
        constexpr int face_steps = 3; // as DihedralEmbeddingOptions.local_global_steps
        laplacian.set_lengths(target.edge_lengths);
        const FaceLayout layout =
            lay_out_faces(topology, target.edge_lengths, target.dihedral_angles);
        Rotations frames = face_frames(topology, from);
        Points points = laplacian.positions(layout, frames);
        for (int step = 0; step < face_steps; ++step) {
            frames = fit_faces(topology, layout, laplacian.weights(), points, std::move(frames));
            points = laplacian.positions(layout, frames);
        }
        return points;
    }

    /// Gauss-Newton steps from start, the result in the pose of another mesh.
    ContinuedMesh descend(const LengthDihedralEnergy& energy, const Points& start,
                          const Points& pose, const ContinuationOptions& options)
    {
        const GaussNewtonResult found =
            solver.minimize(energy, start.reshaped<Eigen::RowMajor>(),
                            {.max_iterations = options.max_iterations,
                             .decrease_tolerance = options.decrease_tolerance,
                             .stiffness = options.stiffness},
                            &factor);
        const Points points =
            Eigen::Map<const Points>(found.points.data(), topology.vertex_count(), 3);
        return {best_rigid_motion(points, pose)(points), found.value, found.iterations,
                found.converged};
    }

    /// |l / l* - 1| of every edge.
    [[nodiscard]] VectorXd edge_errors(const VectorXd& points, const VectorXd& lengths) const
    {
        const Eigen::Map<const Points> rows(points.data(), topology.vertex_count(), 3);
        return (edge_lengths(topology, rows).cwiseQuotient(lengths).array() - 1.0).abs();
    }

    /// The energy of lengths and of the angles that a mesh has.
    [[nodiscard]] LengthDihedralEnergy own_energy(const VectorXd& points, const VectorXd& lengths,
                                                  double smoothness) const
    {
        const Eigen::Map<const Points> rows(points.data(), topology.vertex_count(), 3);
        return {topology, {lengths, dihedral_angles(topology, rows)}, smoothness};
    }

    /// A round of settle(): of the whole mesh, or region by region.
    /// @return What was taken of the step, the least of all regions.
    double settle_all(ContinuedMesh& mesh, VectorXd& points, const LengthDihedralEnergy& energy,
                      const GaussNewtonOptions& options)
    {
        GaussNewtonResult found = solver.minimize(energy, std::move(points), options, &factor);
        points = std::move(found.points);
        mesh.iterations += found.iterations;
        return found.last_step;
    }
    double settle_regions(ContinuedMesh& mesh, VectorXd& points, const LengthDihedralEnergy& energy,
                          double stiffness, const std::vector<std::vector<int>>& regions) const
    {
        double part = 1.0;
        for (const std::vector<int>& region : regions) {
            GaussNewtonResult found =
                GaussNewton(topology, unknowns_of(topology, region))
                    .minimize(energy, std::move(points),
                              {.max_iterations = region_steps,
                               .decrease_tolerance = 0.1, // the next round goes on
                               .stiffness = stiffness});
            points = std::move(found.points);
            mesh.iterations += found.iterations;
            part = std::min(part, found.last_step);
        }
        return part;
    }

    void check_mesh(const Points& from) const
    {
        if (from.rows() != topology.vertex_count())
            throw InvalidInput(join("from has ", from.rows(), " rows, the topology ",
                                    topology.vertex_count(), " vertices"));
    }

    Topology topology;
    GradedLaplacian laplacian;
    GaussNewton solver;
    std::optional<SparseCholesky> factor; ///< The solver keeps it from one mesh to the next.
};

Continuation::Continuation(const Topology& topology, const VectorXd& lengths)
{
    check_lengths(topology, lengths);
    state_ = std::make_unique<State>(topology, graded_unknowns(topology, lengths));
}

Continuation::~Continuation() = default;
Continuation::Continuation(Continuation&&) noexcept = default;
Continuation& Continuation::operator=(Continuation&&) noexcept = default;

ContinuedMesh Continuation::move(const Points& from, const ShapePoint& target,
                                 const ContinuationOptions& options)
{
    check(options);
    state_->check_mesh(from);
    const LengthDihedralEnergy energy(state_->topology, target, options.smoothness);
    return state_->descend(energy, state_->linear_start(from, target), from, options);
}

ContinuedMesh Continuation::settle(const Points& from, const VectorXd& lengths,
                                   const SettlingOptions& options)
{
    check(options);
    State& state = *state_;
    state.check_mesh(from);
    check_lengths(state.topology, lengths);
    ContinuedMesh mesh;
    VectorXd points;
    double smoothness = 0.0;
    double smoothness_in_regions = 0.0;
    int rings = 0;
    const auto start = [&] {
        points = from.reshaped<Eigen::RowMajor>();
        smoothness = options.smoothness;
        smoothness_in_regions = region_smoothness * options.smoothness;
        rings = first_rings;
    };
    start();
    for (int round = 0;; ++round) {
        VectorXd errors = state.edge_errors(points, lengths);
        mesh.converged = errors.maxCoeff() <= options.edge_tolerance;
        if (mesh.converged || round == options.rounds)
            break;
        if (round == quick_rounds) {
            start();
            errors = state.edge_errors(points, lengths);
        }
        const std::vector<std::vector<int>> regions =
            few_regions(state.topology, errors, options.edge_tolerance, rings);
        if (!regions.empty()) {
            const double part = state.settle_regions(
                mesh, points, state.own_energy(points, lengths, smoothness_in_regions),
                options.stiffness, regions);
            smoothness_in_regions = next_smoothness(smoothness_in_regions, part);
            rings += more_rings;
        } else {
            const double part =
                state.settle_all(mesh, points, state.own_energy(points, lengths, smoothness),
                                 {.max_iterations = round < quick_rounds ? 1 : thorough_steps,
                                  .decrease_tolerance = ContinuationOptions().decrease_tolerance,
                                  .stiffness = options.stiffness});
            smoothness = next_smoothness(smoothness, part);
        }
    }
    for (const double error : state.edge_errors(points, lengths))
        mesh.energy +=
            stretch_term(options.stiffness * error).value / (options.stiffness * options.stiffness);
    mesh.points = Eigen::Map<const Points>(points.data(), from.rows(), 3);
    if (mesh.iterations > 0)
        mesh.points = best_rigid_motion(mesh.points, from)(mesh.points);
    return mesh;
}

ContinuedMesh Continuation::adjust(const Points& from, const ShapePoint& target,
                                   const ContinuationOptions& options)
{
    check(options);
    state_->check_mesh(from);
    const LengthDihedralEnergy energy(state_->topology, target, options.smoothness);
    return state_->descend(energy, from, from, options);
}

} // namespace shape
