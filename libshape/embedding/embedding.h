// SPDX-License-Identifier: MIT

#pragma once

#include <optional>

#include "libshape/edge_space/shape_vectors.h"
#include "libshape/embedding/dihedral_embedding.h"
#include "libshape/embedding/multiscale_embedding.h"
#include "libshape/embedding/report.h"
#include "libshape/mesh/points.h"
#include "libshape/mesh/topology.h"

namespace shape {

/// Where the time of EmbeddingMethod::Multiscale goes.
struct MultiscaleTimes
{
    MultiscaleSetupTimes setup;
    MultiscalePoseTimes pose;
};

/// A mesh and what it is worth.
struct Embedding
{
    Points points; ///< #V by 3 [length], centroid at 0.
    EmbeddingReport report;
    std::optional<MultiscaleTimes> multiscale = {}; ///< Of that method.
};

/// A mesh that needs no embedding, as one: its targets are its own lengths and angles. The centroid
/// moves to 0.
[[nodiscard]] Embedding as_embedding(const Topology& topology, Points points);

/// What every method ends with: points moved rigidly onto the reference, their centroid then to 0,
/// and measured against the target; what the solver alone knows is left open, closure_energy is that of
/// the target.
[[nodiscard]] Embedding finished_embedding(const Topology& topology, const Points& points,
                                           const Points& reference, const ShapePoint& target);

/// EmbeddingMethod::Dihedral from beginning to end; `seconds` are left open.
/// @throws as DihedralEmbedder::embed().
[[nodiscard]] Embedding embed_by_dihedrals(const DihedralEmbedder& embedder,
                                           const Topology& topology, const Points& reference,
                                           const ShapePoint& target,
                                           const DihedralEmbeddingOptions& options);

} // namespace shape
