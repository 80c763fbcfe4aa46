// SPDX-License-Identifier: MIT

#pragma once

#include <chrono>

#include "libshape/edge_space/shape_vectors.h"
#include "libshape/embedding/dihedral/dihedral_embedding.h"
#include "libshape/embedding/embedder.h"
#include "libshape/mesh/points.h"
#include "libshape/mesh/topology.h"

namespace shape::internal {

using Clock = std::chrono::steady_clock;

[[nodiscard]] inline double seconds_since(Clock::time_point start)
{
    return std::chrono::duration<double>(Clock::now() - start).count();
}

/// measure_embedding() with the edge_lengths() of the points found before as well.
/// @throws InvalidInput if the target does not fit the topology.
[[nodiscard]] EmbeddingReport report_of(const Topology& topology, const Points& points,
                                        const Eigen::VectorXd& lengths, const ShapePoint& target,
                                        const EdgeResiduals& residuals);

/// What every method ends with: points moved rigidly onto the reference, their centroid then to 0,
/// and measured against the target; what the solver alone knows is left open, closure_energy is that of
/// the target.
/// @param start  When the embedding began; its `seconds` end before it is measured.
/// @param residuals  Become those of the embedding, if given.
[[nodiscard]] Embedding finished_embedding(const Topology& topology, const Points& points,
                                           const Points& reference, const ShapePoint& target,
                                           Clock::time_point start,
                                           EdgeResiduals* residuals = nullptr);

/// The same of what a DihedralEmbedder made, with its own figures.
[[nodiscard]] Embedding finished_embedding(const Topology& topology,
                                           const DihedralEmbedding& nearest,
                                           const Points& reference, const ShapePoint& target,
                                           Clock::time_point start,
                                           EdgeResiduals* residuals = nullptr);

/// EmbeddingMethod::Dihedral from beginning to end.
/// @throws as DihedralEmbedder::embed().
[[nodiscard]] Embedding embed_by_dihedrals(const DihedralEmbedder& embedder,
                                           const Topology& topology, const Points& reference,
                                           const ShapePoint& target,
                                           const DihedralEmbeddingOptions& options,
                                           EdgeResiduals* residuals = nullptr);

} // namespace shape::internal
