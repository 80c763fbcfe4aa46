// SPDX-License-Identifier: MIT

#include "libshape/embedding/dihedral_embedding.h"

#include <utility>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/threads.h"
#include "libshape/embedding/closure.h"
#include "libshape/embedding/face_layout.h"
#include "libshape/embedding/fold_repair.h"
#include "libshape/embedding/length_dihedral_energy.h"
#include "libshape/embedding/patch_frames.h"
#include "libshape/linalg/minimize.h"
#include "libshape/linalg/sparse_cholesky.h"
#include "libshape/mesh/alignment.h"
#include "libshape/mesh/edge_lengths.h"

namespace shape {
namespace {

using Eigen::Matrix3d;
using Eigen::VectorXd;

/// Laplacian of the half-edges with weights w: every edge counts once a face.
SparseMatrix halfedge_laplacian(const Topology& topology, const VectorXd& weights)
{
    std::vector<Eigen::Triplet<double>> entries;
    entries.reserve(static_cast<std::size_t>(3 * topology.edge_count()) + 1);
    for (int e = 0; e < topology.edge_count(); ++e) {
        const double w = topology.is_boundary_edge(e) ? weights[e] : 2.0 * weights[e];
        const int a = topology.edges()(e, 0);
        const int b = topology.edges()(e, 1);
        entries.emplace_back(a, a, w);
        entries.emplace_back(b, b, w);
        entries.emplace_back(b, a, -w);
    }
    entries.emplace_back(0, 0, weights.mean()); // holds the translation
    SparseMatrix laplacian(topology.vertex_count(), topology.vertex_count());
    laplacian.setFromTriplets(entries.begin(), entries.end());
    return laplacian;
}

/// Trust in the transition across every edge: 1 / (1 + (r_u^2 + r_v^2) / 0.1^2) with the closure
/// residuals r [rad] at its ends. A few wild loops (slivers, folds) must not turn all frames.
VectorXd transition_weights(const Topology& topology, const Points& corner_angles,
                            const VectorXd& dihedral_angles)
{
    constexpr double scale = 0.1;
    const VectorXd squares =
        closure_residuals(topology, corner_angles, dihedral_angles).rowwise().squaredNorm();
    VectorXd weights(topology.edge_count());
    for (int e = 0; e < topology.edge_count(); ++e)
        weights[e] = 1.0 / (1.0 + (squares[topology.edges()(e, 0)] +
                                   squares[topology.edges()(e, 1)]) /
                                      (scale * scale));
    return weights;
}

} // namespace

struct DihedralEmbedder::State
{
    Topology topology;
    std::vector<Points> references;
    PatchFrames patches;
    VectorXd weights; // #E, 1 / l^2 of the first reference
    SparseCholesky laplacian;

    State(const Topology& t, std::vector<Points> meshes)
        : topology(t),
          references(std::move(meshes)),
          patches(t),
          weights(edge_lengths(t, references.front()).array().square().inverse()),
          laplacian(halfedge_laplacian(t, weights))
    {}

    /// Least-squares positions for half-edges that face f wants as frames[f] * halfedges.
    [[nodiscard]] Points positions(const std::vector<Matrix3d>& frames,
                                   const Points& halfedges) const
    {
        Eigen::MatrixXd rhs(topology.vertex_count(), 3);
        parallel_for(
            static_cast<std::size_t>(topology.vertex_count()), 1024,
            [&](std::size_t begin, std::size_t end) {
                for (int v = static_cast<int>(begin); v < static_cast<int>(end); ++v) {
                    Eigen::RowVector3d sum = Eigen::RowVector3d::Zero();
                    for (const int out : topology.outgoing(v)) {
                        const int in = Topology::previous(out);
                        sum += (weights[topology.edge(in)] * halfedges.row(in) -
                                weights[topology.edge(out)] * halfedges.row(out)) *
                               frames[static_cast<std::size_t>(out / 3)].transpose();
                    }
                    rhs.row(v) = sum;
                }
            });
        return laplacian.solve(rhs);
    }

    /// Every wedge of two faces, rigid as laid out, is rotated to its best fit to the points; a face
    /// wants the mean of what its wedges want.
    [[nodiscard]] std::vector<Matrix3d> fitted_frames(const FaceLayout& layout,
                                                      const Points& points,
                                                      std::vector<Matrix3d> frames) const
    {
        std::vector<Matrix3d> fits(static_cast<std::size_t>(topology.edge_count()));
        parallel_for(fits.size(), 512, [&](std::size_t begin, std::size_t end) {
            for (std::size_t e = begin; e < end; ++e) {
                Matrix3d sum = Matrix3d::Zero();
                const auto add = [&](int face, const Matrix3d& frame) {
                    for (int h = 3 * face; h < 3 * face + 3; ++h)
                        sum += weights[topology.edge(h)] *
                               (points.row(topology.target(h)) - points.row(topology.source(h)))
                                   .transpose() *
                               (layout.halfedges.row(h) * frame.transpose());
                };
                const auto edge = static_cast<int>(e);
                if (topology.is_boundary_edge(edge))
                    continue;
                add(topology.edge_halfedges()(edge, 0) / 3, Matrix3d::Identity());
                add(topology.edge_halfedges()(edge, 1) / 3, layout.transitions[e]);
                fits[e] = nearest_rotation(sum);
            }
        });
        parallel_for(frames.size(), 2048, [&](std::size_t begin, std::size_t end) {
            for (std::size_t f = begin; f < end; ++f) {
                Matrix3d sum = Matrix3d::Zero();
                int wedges = 0;
                for (int h = static_cast<int>(3 * f); h < static_cast<int>(3 * f + 3); ++h) {
                    if (topology.opposite(h) < 0)
                        continue;
                    const int edge = topology.edge(h);
                    const auto e = static_cast<std::size_t>(edge);
                    const bool left = topology.edge_halfedges()(edge, 0) == h;
                    sum += left ? fits[e] : Matrix3d(fits[e] * layout.transitions[e]);
                    ++wedges;
                }
                if (wedges > 0)
                    frames[f] = sum / wedges;
            }
        });
        return frames;
    }
};

DihedralEmbedder::DihedralEmbedder(const Topology& topology, std::vector<Points> references)
{
    if (references.empty())
        throw InvalidInput("the embedding needs at least one reference mesh");
    for (const Points& reference : references)
        if (!(edge_lengths(topology, reference).minCoeff() > 0.0))
            throw InvalidInput("a reference mesh has an edge of length 0");
    state_ = std::make_unique<State>(topology, std::move(references));
}

DihedralEmbedder::~DihedralEmbedder() = default;
DihedralEmbedder::DihedralEmbedder(DihedralEmbedder&&) noexcept = default;
DihedralEmbedder& DihedralEmbedder::operator=(DihedralEmbedder&&) noexcept = default;

DihedralEmbedding DihedralEmbedder::embed(const ShapePoint& target,
                                          const DihedralEmbeddingOptions& options) const
{
    const State& s = *state_;
    const LengthDihedralEnergy energy(s.topology, target, options.smoothness);
    const Points corners = corner_angles(s.topology, target.edge_lengths);
    const FaceLayout layout =
        lay_out_faces(s.topology, target.edge_lengths, corners, target.dihedral_angles);

    DihedralEmbedding result;
    std::vector<Matrix3d> frames = s.patches.face_frames(
        layout.transitions, transition_weights(s.topology, corners, target.dihedral_angles));
    Points start = s.positions(frames, layout.halfedges);
    for (int step = 0; step < options.local_global_steps; ++step) {
        frames = s.fitted_frames(layout, start, std::move(frames));
        start = s.positions(frames, layout.halfedges);
    }
    result.back_substitutions = 1 + options.local_global_steps;

    FoldRepair repair = repair_folds(energy, s.references, start.reshaped<Eigen::RowMajor>());
    result.repaired_folds = repair.replaced;
    const Objective objective = [&](const VectorXd& x, VectorXd& gradient) {
        return energy.evaluate(x, gradient);
    };
    const Preconditioner precondition = [&](const VectorXd& g) -> VectorXd {
        const Eigen::Map<const Points> rows(g.data(), s.topology.vertex_count(), 3);
        return s.laplacian.solve(rows).reshaped<Eigen::RowMajor>();
    };
    // Rounding: strains of 1e-13 an edge are none.
    const double nothing = 1e-26 * s.topology.edge_count();
    constexpr int rounds = 3;
    for (int round = 0; round < rounds; ++round) {
        const Minimum minimum =
            minimize(objective, precondition, std::move(repair.points),
                     {.max_iterations = options.max_iterations - result.iterations,
                      .decrease_tolerance = options.decrease_tolerance,
                      .value_tolerance = nothing});
        result.iterations += minimum.iterations;
        result.energy = minimum.value;
        result.converged = minimum.converged;
        repair = {minimum.point, 0, 0};
        if (round + 1 == rounds || result.iterations >= options.max_iterations)
            break;
        repair = repair_folds(energy, s.references, std::move(repair.points));
        result.repaired_folds += repair.replaced;
        if (repair.replaced == 0)
            break;
    }
    result.back_substitutions += result.iterations;
    const Eigen::Map<const Points> points(repair.points.data(), s.topology.vertex_count(), 3);
    result.points = points.rowwise() - points.colwise().mean();
    return result;
}

} // namespace shape
