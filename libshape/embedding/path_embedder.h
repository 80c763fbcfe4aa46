// SPDX-License-Identifier: MIT

#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "libshape/base/progress.h"
#include "libshape/edge_space/shape_vectors.h"
#include "libshape/embedding/embedder.h"
#include "libshape/mesh/points.h"
#include "libshape/mesh/topology.h"

namespace shape {

/// A path through edge-length space.
struct TargetPath
{
    std::function<ShapePoint(double)> target; ///< What is wanted at t. Safe to call concurrently.
    std::vector<double> stations; ///< Ascending, two or more: where it passes through meshes,
                                  ///< and its ends.
    int steps = 60; ///< At which it is solved, dealt out to the parts between stations, 8 at the
                    ///< least to each; >= 8.
};

/// Embeds the points of a path so that neighbours agree on every fold. An Embedder takes each
/// point by itself, and where the best of several minima changes from one point to the next, the mesh
/// jumps. Here meshes are followed from station to station from both sides, and every fold that the
/// two have in different ways turns over gradually where that costs least (docs/embedding.md). The mesh
/// at a place depends on the path alone, not on which other places are asked for.
///
/// The first call solves the path at its even steps, for about as much as 1.7 calls of
/// Embedder::embed() each, and keeps 24 bytes a vertex and step; the others cost a third of one and less.
class PathEmbedder
{
public:
    /// @param references  As Embedder takes them.
    /// @param options  Of EmbeddingMethod::Dihedral, EmbeddingQuality::Fine. A larger anchor than 0.01, the default
    ///     here (CoherentPathOptions), counts as that.
    /// @throws InvalidInput if another method or quality is chosen, stations do not ascend, there are
    ///     fewer than 8 steps, or as Embedder does.
    PathEmbedder(const Topology& topology, std::vector<Points> references, TargetPath path,
                 const EmbeddingOptions& options = {}, Progress progress = {});
    ~PathEmbedder();
    PathEmbedder(PathEmbedder&&) noexcept;
    PathEmbedder& operator=(PathEmbedder&&) noexcept;

    /// The mesh at t; `converged` is false where a fold is turning over.
    /// @throws InvalidInput if t is not within the stations; else as Embedder::embed().
    /// Safe to call concurrently.
    [[nodiscard]] Embedding embed(double t) const;

private:
    struct State;
    std::unique_ptr<State> state_;
};

} // namespace shape
