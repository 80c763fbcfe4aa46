// SPDX-License-Identifier: MIT

#include "libshape/embedding/finished_embedding.h"

#include <utility>

#include "libshape/edge_space/admissibility.h"
#include "libshape/embedding/closure/closure.h"
#include "libshape/mesh/alignment.h"
#include "libshape/mesh/dihedral_angles.h"
#include "libshape/mesh/edge_lengths.h"

namespace shape {
using namespace internal;
namespace {

/// E of the target of an embedding, before anything is solved.
double closure_energy_of(const Topology& topology, const ShapePoint& target)
{
    return closure_energy(topology, positive_lengths(target.edge_lengths), target.dihedral_angles);
}

} // namespace

Embedding as_embedding(const Topology& topology, Points points)
{
    points.rowwise() -= centroid(points);
    const ShapePoint target{edge_lengths(topology, points), dihedral_angles(topology, points)};
    Embedding embedding{std::move(points), {}};
    embedding.report = measure_embedding(topology, embedding.points, target);
    embedding.report.closure_energy = closure_energy_of(topology, target);
    embedding.report.converged = true;
    return embedding;
}

Embedding internal::finished_embedding(const Topology& topology, const Points& points,
                                       const Points& reference, const ShapePoint& target,
                                       Clock::time_point start, EdgeResiduals* residuals)
{
    Embedding embedding{best_rigid_motion(points, reference)(points), {}};
    embedding.points.rowwise() -= centroid(embedding.points);
    const double seconds = seconds_since(start);
    EdgeResiduals found = edge_residuals(topology, embedding.points, target);
    embedding.report = measure_embedding(topology, embedding.points, target, found);
    if (residuals != nullptr)
        *residuals = std::move(found);
    embedding.report.closure_energy = closure_energy_of(topology, target);
    embedding.report.seconds = seconds;
    return embedding;
}

Embedding internal::finished_embedding(const Topology& topology, const DihedralEmbedding& nearest,
                                       const Points& reference, const ShapePoint& target,
                                       Clock::time_point start, EdgeResiduals* residuals)
{
    Embedding embedding =
        finished_embedding(topology, nearest.points, reference, target, start, residuals);
    if (nearest.companion.rows() > 0)
        embedding.report.companion_rms =
            100.0 * relative_distance(
                        embedding.points,
                        best_rigid_motion(nearest.companion, embedding.points)(nearest.companion));
    embedding.report.iterations = nearest.iterations;
    embedding.report.converged = nearest.converged;
    return embedding;
}

Embedding internal::embed_by_dihedrals(const DihedralEmbedder& embedder, const Topology& topology,
                                       const Points& reference, const ShapePoint& target,
                                       const DihedralEmbeddingOptions& options,
                                       EdgeResiduals* residuals)
{
    const Clock::time_point start = Clock::now();
    return finished_embedding(topology, embedder.embed(target, options), reference, target, start,
                              residuals);
}

} // namespace shape
