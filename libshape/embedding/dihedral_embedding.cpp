// SPDX-License-Identifier: MIT

#include "libshape/embedding/dihedral_embedding.h"

#include <utility>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/edge_space/admissibility.h"
#include "libshape/embedding/descent.h"
#include "libshape/embedding/edge_laplacian.h"
#include "libshape/embedding/face_fit.h"
#include "libshape/embedding/face_layout.h"
#include "libshape/embedding/hot_spots.h"
#include "libshape/embedding/length_dihedral_energy.h"
#include "libshape/embedding/patch_frames.h"
#include "libshape/mesh/edge_lengths.h"
#include "libshape/mesh/renumbering.h"

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
    Renumbering renumbering; // all else is in its order
    std::vector<Points> references;
    PatchFrames patches;
    EdgeLaplacian laplacian; // of the references' mean lengths
    SinglePrecisionSolve preconditioner;

    State(const Topology& topology, const std::vector<Points>& meshes)
        : renumbering(renumber_for_locality(topology)),
          references(in_order(renumbering, meshes)),
          patches(renumbering.topology),
          laplacian(renumbering.topology, mean_lengths(renumbering.topology, references)),
          preconditioner(laplacian.single_precision())
    {
    }

    static std::vector<Points> in_order(const Renumbering& renumbering,
                                        const std::vector<Points>& meshes)
    {
        std::vector<Points> ordered;
        for (const Points& mesh : meshes)
            ordered.push_back(renumbered(renumbering, mesh));
        return ordered;
    }
};

DihedralEmbeddingOptions dihedral_preview()
{
    DihedralEmbeddingOptions preview;
    preview.local_global_steps = 2;
    preview.relax_start = true;
    preview.max_iterations = 9;
    preview.first_linear_steps = 4;
    preview.repairs = {9};
    preview.folds.fold_angle = 2.0; // what is about to turn over
    preview.repair.descent.newton_steps = 4;
    return preview;
}

DihedralEmbedder::DihedralEmbedder(const Topology& topology, const std::vector<Points>& references)
{
    if (references.empty())
        throw InvalidInput("the embedding needs at least one reference mesh");
    for (const Points& reference : references)
        if (!(edge_lengths(topology, reference).minCoeff() > 0.0))
            throw InvalidInput("a reference mesh has an edge of length 0");
    state_ = std::make_unique<State>(topology, references);
}

DihedralEmbedder::~DihedralEmbedder() = default;
DihedralEmbedder::DihedralEmbedder(DihedralEmbedder&&) noexcept = default;
DihedralEmbedder& DihedralEmbedder::operator=(DihedralEmbedder&&) noexcept = default;

DihedralEmbedding DihedralEmbedder::embed(const ShapePoint& point,
                                          const DihedralEmbeddingOptions& options) const
{
    const State& s = *state_;
    const Topology& topology = s.renumbering.topology;
    if (point.edge_lengths.size() != topology.edge_count() ||
        point.dihedral_angles.size() != topology.edge_count())
        throw InvalidInput(join("target has ", point.edge_lengths.size(), " lengths and ",
                                point.dihedral_angles.size(), " dihedral angles, the topology ",
                                topology.edge_count(), " edges"));
    const ShapePoint target{positive_lengths(point.edge_lengths(s.renumbering.edges)),
                            point.dihedral_angles(s.renumbering.edges)};
    LengthDihedralEnergy energy(topology, target, options.smoothness);
    const FaceLayout layout = lay_out_faces(topology, target.edge_lengths, target.dihedral_angles);

    DihedralEmbedding result;
    const VectorXd trust = transition_weights(topology, layout.transitions);
    // Where every walk closes there may be a mesh with all lengths and angles as wanted, and single
    // precision would lose it.
    const bool closes = trust.minCoeff() > 0.999;
    const auto positions = [&](const std::vector<Matrix3d>& frames) {
        ++result.back_substitutions;
        return closes ? s.laplacian.positions(frames, layout.halfedges)
                      : s.laplacian.positions(frames, layout.halfedges, s.preconditioner);
    };
    std::vector<Matrix3d> frames = s.patches.face_frames(layout.transitions, trust);
    Points start = positions(frames);
    for (int step = 0; step < options.local_global_steps; ++step) {
        frames = fit_faces(topology, layout, s.laplacian.weights(), start, std::move(frames));
        start = positions(frames);
    }

    // Rounding: strains of 1e-12 an edge are none.
    const double nothing = 1e-24 * topology.edge_count();
    VectorXd points = start.reshaped<Eigen::RowMajor>();
    const auto descend_to = [&](int iterations) {
        Descent descent = descend(energy, s.preconditioner, std::move(points),
                                  {.max_linear_steps = iterations - result.iterations,
                                   .first_linear_steps = options.first_linear_steps,
                                   .decrease_tolerance = options.decrease_tolerance,
                                   .value_tolerance = nothing});
        points = std::move(descent.points);
        result.iterations += descent.linear_steps;
        result.energy = descent.energy;
        result.converged = descent.converged;
    };
    const auto repair = [&](std::vector<std::vector<int>> regions) {
        RegionRepair repaired = repair_regions(energy, s.references, std::move(points),
                                               std::move(regions), options.repair);
        points = std::move(repaired.points);
        result.energy -= repaired.decrease;
        result.repaired_regions += repaired.replaced;
        result.converged = result.converged && repaired.replaced == 0;
    };
    if (options.relax_start)
        repair(hot_spots(energy, points));
    // Folds show once what is rough about the start is gone.
    for (const int iterations : options.repairs)
        if (iterations <= options.max_iterations && !result.converged) {
            descend_to(iterations);
            repair(folded_regions(topology, points, target.dihedral_angles, options.folds));
        }
    if (result.iterations < options.max_iterations && !result.converged)
        descend_to(options.max_iterations);
    result.back_substitutions += result.iterations;
    const Eigen::Map<const Points> vertices(points.data(), topology.vertex_count(), 3);
    result.points = restored(s.renumbering, vertices.rowwise() - vertices.colwise().mean());
    return result;
}

} // namespace shape
