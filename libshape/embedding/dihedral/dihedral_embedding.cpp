// SPDX-License-Identifier: MIT

#include "libshape/embedding/dihedral/dihedral_embedding.h"

#include <utility>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/pool.h"
#include "libshape/base/require.h"
#include "libshape/edge_space/admissibility.h"
#include "libshape/embedding/energy/descent.h"
#include "libshape/embedding/energy/length_dihedral_energy.h"
#include "libshape/embedding/repair/hot_spots.h"
#include "libshape/embedding/start/edge_laplacian.h"
#include "libshape/embedding/start/face_fit.h"
#include "libshape/embedding/start/face_layout.h"
#include "libshape/embedding/start/linear_start.h"
#include "libshape/mesh/alignment.h"
#include "libshape/mesh/edge_lengths.h"
#include "libshape/mesh/renumbering.h"

namespace shape::internal {
namespace {

using Eigen::VectorXd;

VectorXd mean_lengths(const Topology& topology, const std::vector<Points>& meshes)
{
    VectorXd sum = VectorXd::Zero(topology.edge_count());
    for (const Points& mesh : meshes)
        sum += edge_lengths(topology, mesh);
    return sum / static_cast<double>(meshes.size());
}

void check(const Topology& topology, const std::vector<Points>& references)
{
    if (references.empty())
        throw InvalidInput("the embedding needs at least one reference mesh");
    for (const Points& reference : references)
        if (!(edge_lengths(topology, reference).minCoeff() > 0.0))
            throw InvalidInput("a reference mesh has an edge of length 0");
}

} // namespace

struct DihedralEmbedder::State
{
    Renumbering renumbering; // all else is in its order
    std::vector<Points> references;
    EdgeLaplacian laplacian; // of the references' mean lengths
    Pool<LinearStart> starts;

    /// @param factor  Of the Laplacian, if it is known: one or none.
    template <class... Factor>
    State(const Topology& topology, const std::vector<Points>& meshes, Factor&&... factor)
        : renumbering(renumber_for_locality(topology)),
          references(in_order(renumbering, meshes)),
          laplacian(renumbering.topology, mean_lengths(renumbering.topology, references),
                    std::forward<Factor>(factor)...),
          starts([this, patches = std::make_shared<FacePatches>(renumbering.topology, 64)] {
              return std::make_unique<LinearStart>(renumbering.topology, patches, laplacian,
                                                   laplacian.single_precision());
          })
    {
    }

    static std::vector<Points> in_order(const Renumbering& renumbering,
                                        const std::vector<Points>& meshes)
    {
        std::vector<Points> ordered;
        ordered.reserve(meshes.size());
        for (const Points& mesh : meshes)
            ordered.push_back(renumbered(renumbering, mesh));
        return ordered;
    }
};

namespace {

/// A target in the order of the renumbering, fit for the energy.
ShapePoint target_of(const Renumbering& renumbering, const ShapePoint& point)
{
    const Topology& topology = renumbering.topology;
    if (point.edge_lengths.size() != topology.edge_count() ||
        point.dihedral_angles.size() != topology.edge_count())
        throw InvalidInput(join("target has ", point.edge_lengths.size(), " lengths and ",
                                point.dihedral_angles.size(), " dihedral angles, the topology ",
                                topology.edge_count(), " edges"));
    return {positive_lengths(renumbered(renumbering, point.edge_lengths)),
            renumbered(renumbering, point.dihedral_angles)};
}

/// Vertices row by row in the order of the renumbering, in their own, about their centroid.
Points result_of(const Renumbering& renumbering, const VectorXd& points)
{
    Points result = restored(
        renumbering,
        Eigen::Map<const Points>(points.data(), renumbering.topology.vertex_count(), 3));
    result.rowwise() -= centroid(result);
    return result;
}

} // namespace

void check(const DihedralEmbeddingOptions& options)
{
    require_positive(options.smoothness, "DihedralEmbeddingOptions.smoothness");
    require_at_least(0, options.local_global_steps, "DihedralEmbeddingOptions.local_global_steps");
    require_at_least(0, options.max_iterations, "DihedralEmbeddingOptions.max_iterations");
    require_at_least(2, options.first_linear_steps, "DihedralEmbeddingOptions.first_linear_steps");
    int before = 0;
    for (std::size_t i = 0; i < options.repairs.size(); before = options.repairs[i++])
        require(options.repairs[i] >= before, join("DihedralEmbeddingOptions.repairs[", i, "]"),
                options.repairs[i], join(">= ", before, ": ascending and not negative"));
    check(options.folds);
    check(options.repair);
    require_not_negative(options.decrease_tolerance, "DihedralEmbeddingOptions.decrease_tolerance");
}

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
    check(topology, references);
    state_ = std::make_unique<State>(topology, references);
}

DihedralEmbedder::DihedralEmbedder(const Topology& topology, const std::vector<Points>& references,
                                   SinglePrecisionSolve factor)
{
    check(topology, references);
    state_ = std::make_unique<State>(topology, references, std::move(factor));
}

const SinglePrecisionSolve& DihedralEmbedder::factor() const
{
    return state_->laplacian.single_precision();
}

DihedralEmbedder::~DihedralEmbedder() = default;
DihedralEmbedder::DihedralEmbedder(DihedralEmbedder&&) noexcept = default;
DihedralEmbedder& DihedralEmbedder::operator=(DihedralEmbedder&&) noexcept = default;

DihedralEmbedding DihedralEmbedder::embed(const ShapePoint& point,
                                          const DihedralEmbeddingOptions& options) const
{
    check(options);
    State& s = *state_;
    const Topology& topology = s.renumbering.topology;
    const ShapePoint target = target_of(s.renumbering, point);
    LengthDihedralEnergy energy(topology, target, options.smoothness);
    const auto start = s.starts.borrow();
    const Points& linear = start->points(target, options.local_global_steps);

    DihedralEmbedding result;
    result.back_substitutions = options.local_global_steps + 1;
    // Rounding: strains of 1e-12 an edge are none.
    const double nothing = 1e-24 * topology.edge_count();
    VectorXd points = linear.reshaped<Eigen::RowMajor>();
    Descender descender(energy, s.laplacian.single_precision());
    const auto descend_to = [&](int iterations) {
        Descent descent = descender.descend(std::move(points),
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
    if (result.iterations == 0 ||
        (result.iterations < options.max_iterations && !result.converged)) {
        energy.keep_areas();
        descend_to(options.max_iterations);
    }
    result.back_substitutions += result.iterations;
    result.points = result_of(s.renumbering, points);
    return result;
}

DihedralEmbedding DihedralEmbedder::sweep(const ShapePoint& point, const Points& start,
                                          int linear_steps, double smoothness) const
{
    const State& s = *state_;
    const ShapePoint target = target_of(s.renumbering, point);
    if (start.rows() != s.renumbering.topology.vertex_count())
        throw InvalidInput(join("sweep: the start has ", start.rows(), " vertices, the topology ",
                                s.renumbering.topology.vertex_count()));
    LengthDihedralEnergy energy(s.renumbering.topology, target, smoothness);
    Descender descender(energy, s.laplacian.single_precision());
    const Descent descent =
        descender.descend(renumbered(s.renumbering, start).reshaped<Eigen::RowMajor>(),
                          {.max_linear_steps = linear_steps, .first_linear_steps = linear_steps});
    DihedralEmbedding result;
    result.points = result_of(s.renumbering, descent.points);
    result.energy = descent.energy;
    result.iterations = result.back_substitutions = descent.linear_steps;
    result.converged = descent.converged;
    return result;
}

} // namespace shape::internal
