// SPDX-License-Identifier: MIT

#include "libshape/embedding/dihedral_embedding.h"

#include <utility>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/edge_space/admissibility.h"
#include "libshape/embedding/edge_laplacian.h"
#include "libshape/embedding/face_layout.h"
#include "libshape/embedding/fold_repair.h"
#include "libshape/embedding/length_dihedral_energy.h"
#include "libshape/embedding/patch_frames.h"
#include "libshape/embedding/wedge_fit.h"
#include "libshape/linalg/minimize.h"
#include "libshape/mesh/edge_lengths.h"

namespace shape {
namespace {

using Eigen::Matrix3d;
using Eigen::VectorXd;

/// Trust in the transition across every edge: 1 / (1 + (r_u^2 + r_v^2) / 0.1^2) with the closure
/// residuals r [rad] at its ends. A few wild loops (slivers, folds) must not turn all frames.
VectorXd transition_weights(const Topology& topology, const std::vector<Matrix3d>& transitions)
{
    constexpr double scale = 0.1;
    const Eigen::ArrayXd squares = closure_cosines(topology, transitions).array().acos().square();
    VectorXd weights(topology.edge_count());
    for (int e = 0; e < topology.edge_count(); ++e)
        weights[e] =
            1.0 / (1.0 + (squares[topology.edges()(e, 0)] + squares[topology.edges()(e, 1)]) /
                             (scale * scale));
    return weights;
}

VectorXd mean_lengths(const Topology& topology, const std::vector<Points>& meshes)
{
    VectorXd sum = VectorXd::Zero(topology.edge_count());
    for (const Points& mesh : meshes)
        sum += edge_lengths(topology, mesh);
    return sum / static_cast<double>(meshes.size());
}

} // namespace

struct DihedralEmbedder::State
{
    Topology topology;
    std::vector<Points> references;
    PatchFrames patches;
    EdgeLaplacian laplacian; // of the references' mean lengths
    SinglePrecisionSolve preconditioner;

    State(const Topology& t, std::vector<Points> meshes)
        : topology(t),
          references(std::move(meshes)),
          patches(t),
          laplacian(t, mean_lengths(t, references)),
          preconditioner(laplacian.single_precision())
    {
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

DihedralEmbedding DihedralEmbedder::embed(const ShapePoint& point,
                                          const DihedralEmbeddingOptions& options) const
{
    const State& s = *state_;
    const ShapePoint target{positive_lengths(point.edge_lengths), point.dihedral_angles};
    const LengthDihedralEnergy energy(s.topology, target, options.smoothness);
    const FaceLayout layout =
        lay_out_faces(s.topology, target.edge_lengths, target.dihedral_angles);

    DihedralEmbedding result;
    std::vector<Matrix3d> frames = s.patches.face_frames(
        layout.transitions, transition_weights(s.topology, layout.transitions));
    Points start = s.laplacian.positions(frames, layout.halfedges);
    for (int step = 0; step < options.local_global_steps; ++step) {
        frames = fit_wedges(s.topology, layout, s.laplacian.weights(), start, std::move(frames));
        start = s.laplacian.positions(frames, layout.halfedges);
    }
    result.back_substitutions = 1 + options.local_global_steps;

    FoldRepair repair =
        repair_folds(energy, s.references, start.reshaped<Eigen::RowMajor>(), options.folds);
    result.repaired_folds = repair.replaced;
    const Objective objective = [&](const VectorXd& x, VectorXd& gradient) {
        return energy.evaluate(x, gradient);
    };
    // The Laplacian bounds the stiffness of an edge in every direction; it has it in one only.
    constexpr double laplacian_scale = 10.0 / 3.0;
    const Preconditioner precondition = [&](const VectorXd& g) -> VectorXd {
        return laplacian_scale * s.preconditioner.solve(g);
    };
    // Rounding: strains of 1e-12 an edge are none.
    const double nothing = 1e-24 * s.topology.edge_count();
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
        repair = repair_folds(energy, s.references, std::move(repair.points), options.folds);
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
