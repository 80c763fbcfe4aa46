// SPDX-License-Identifier: MIT

#include "libshape/embedding/dihedral_embedding.h"

#include <utility>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/pool.h"
#include "libshape/edge_space/admissibility.h"
#include "libshape/embedding/descent.h"
#include "libshape/embedding/edge_laplacian.h"
#include "libshape/embedding/face_patches.h"
#include "libshape/embedding/fold_repair.h"
#include "libshape/embedding/length_dihedral_energy.h"
#include "libshape/embedding/linear_start.h"
#include "libshape/mesh/alignment.h"
#include "libshape/mesh/edge_lengths.h"
#include "libshape/mesh/renumbering.h"

namespace shape {
namespace {

using Eigen::VectorXd;

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
    EdgeLaplacian laplacian; // of the references' mean lengths
    SinglePrecisionSolve preconditioner;
    Pool<LinearStart> starts;

    State(const Topology& topology, const std::vector<Points>& meshes)
        : renumbering(renumber_for_locality(topology)),
          references(in_order(renumbering, meshes)),
          laplacian(renumbering.topology, mean_lengths(renumbering.topology, references)),
          preconditioner(laplacian.single_precision()),
          starts([this, patches = std::make_shared<FacePatches>(renumbering.topology, 64)] {
              return std::make_unique<LinearStart>(renumbering.topology, patches, laplacian,
                                                   preconditioner);
          })
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
    State& s = *state_;
    const Topology& topology = s.renumbering.topology;
    if (point.edge_lengths.size() != topology.edge_count() ||
        point.dihedral_angles.size() != topology.edge_count())
        throw InvalidInput(join("target has ", point.edge_lengths.size(), " lengths and ",
                                point.dihedral_angles.size(), " dihedral angles, the topology ",
                                topology.edge_count(), " edges"));
    const ShapePoint target{positive_lengths(renumbered(s.renumbering, point.edge_lengths)),
                            renumbered(s.renumbering, point.dihedral_angles)};
    LengthDihedralEnergy energy(topology, target, options.smoothness);
    const auto start = s.starts.borrow();
    const Points& linear = start->points(target, options.local_global_steps);

    DihedralEmbedding result;
    result.back_substitutions = options.local_global_steps + 1;
    // Rounding: strains of 1e-12 an edge are none.
    const double nothing = 1e-24 * topology.edge_count();
    const auto descend_by = [&](Eigen::VectorXd from, int steps) {
        Descent descent = descend(energy, s.preconditioner, std::move(from),
                                  {.max_linear_steps = steps,
                                   .first_linear_steps = options.first_linear_steps,
                                   .decrease_tolerance = options.decrease_tolerance,
                                   .value_tolerance = nothing});
        result.iterations += descent.linear_steps;
        result.energy = descent.energy;
        result.converged = descent.converged;
        return descent.points;
    };
    // Folds show once what is rough about the start is gone.
    VectorXd points = descend_by(linear.reshaped<Eigen::RowMajor>(),
                                 std::min(options.steps_before_repair, options.max_iterations));
    if (const int left = options.max_iterations - result.iterations; left > 0) {
        FoldRepair repair = repair_folds(energy, s.references, std::move(points), options.folds);
        result.repaired_folds = repair.replaced;
        points = descend_by(std::move(repair.points), left);
    }
    result.back_substitutions += result.iterations;
    const Eigen::Map<const Points> vertices(points.data(), topology.vertex_count(), 3);
    result.points = restored(s.renumbering, vertices);
    result.points.rowwise() -= centroid(result.points);
    return result;
}

} // namespace shape
