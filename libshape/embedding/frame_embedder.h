// SPDX-License-Identifier: MIT

#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "libshape/base/progress.h"
#include "libshape/edge_space/shape_vectors.h"
#include "libshape/embedding/embedder.h"
#include "libshape/embedding/path_embedder.h"
#include "libshape/mesh/points.h"
#include "libshape/mesh/topology.h"

namespace shape::internal {

/// A path, and where frames are taken of it.
struct FramePath
{
    TargetPath path;
    std::vector<double> places; ///< t of each frame, equally spaced; may lie beyond the stations.
};

/// Embeds blends one by one. Frames of a path make a motion if there are two or more, no farther apart than
/// 1/30 of it,
///
///     |places[1] - places[0]| <= (1 + 1e-9) / 30 (last station - first station);
///
/// by the method Dihedral, Fine, a motion is embedded as a whole between its stations (PathEmbedder). All other
/// blends are embedded by themselves (Embedder).
class FrameEmbedder
{
public:
    /// @param references  As Embedder takes them.
    /// @param along  The path that the frames are of; none: blends of their own.
    /// @param progress  Hears of a motion while it is solved.
    /// @throws InvalidInput if stations do not ascend, or as Embedder does.
    FrameEmbedder(const Topology& topology, const std::vector<Points>& references,
                  const EmbeddingOptions& options, std::optional<FramePath> along = {},
                  const Progress& progress = {});

    /// @param target  What the path wants at the place of the frame, or a blend of its own.
    /// @param place  A mesh that the result is turned and placed as.
    /// @throws InvalidInput if a motion has no such frame; else as Embedder::embed().
    /// Safe to call concurrently.
    [[nodiscard]] Embedding embed(std::size_t frame, const ShapePoint& target,
                                  const Points& place) const;

    /// The same, placed as Embedder does.
    [[nodiscard]] Embedding embed(std::size_t frame, const ShapePoint& target) const;

private:
    Embedder alone_;
    std::optional<FramePath> along_;
    std::optional<PathEmbedder> motion_;
};

} // namespace shape::internal
