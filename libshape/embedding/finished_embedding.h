// SPDX-License-Identifier: MIT

#pragma once

#include "libshape/edge_space/shape_vectors.h"
#include "libshape/embedding/dihedral/dihedral_embedding.h"
#include "libshape/embedding/embedder.h"
#include "libshape/mesh/points.h"
#include "libshape/mesh/topology.h"

namespace shape::internal {

/// What every method ends with: points moved rigidly onto the reference, their centroid then to 0,
/// and measured against the target; what the solver alone knows is left open, closure_energy is that of
/// the target.
[[nodiscard]] Embedding finished_embedding(const Topology& topology, const Points& points,
                                           const Points& reference, const ShapePoint& target);

/// EmbeddingMethod::Dihedral from beginning to end; the seconds are left open.
/// @throws as DihedralEmbedder::embed().
[[nodiscard]] Embedding embed_by_dihedrals(const DihedralEmbedder& embedder,
                                           const Topology& topology, const Points& reference,
                                           const ShapePoint& target,
                                           const DihedralEmbeddingOptions& options);

} // namespace shape::internal
