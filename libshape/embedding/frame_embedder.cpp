// SPDX-License-Identifier: MIT

#include "libshape/embedding/frame_embedder.h"

#include <cmath>
#include <utility>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/embedding/dihedral/coherent_path.h"
#include "libshape/mesh/alignment.h"

namespace shape::internal {
namespace {

bool is_motion(const FramePath& along, const EmbeddingOptions& options)
{
    const std::vector<double>& stations = along.path.stations;
    const bool is_fine = options.method == EmbeddingMethod::Dihedral &&
                         options.quality.value_or(EmbeddingQuality::Fine) == EmbeddingQuality::Fine;
    return is_fine && along.places.size() >= 2 &&
           std::abs(along.places[1] - along.places[0]) <=
               (1.0 + 1e-9) / 30.0 * (stations.back() - stations.front());
}

} // namespace

FrameEmbedder::FrameEmbedder(const Topology& topology, const std::vector<Points>& references,
                             const EmbeddingOptions& options, std::optional<FramePath> along,
                             const Progress& progress)
    : alone_(topology, references, options), along_(std::move(along))
{
    if (!along_)
        return;
    check_stations(along_->path.stations);
    if (is_motion(*along_, options))
        motion_.emplace(topology, references, along_->path, options, progress);
}

Embedding FrameEmbedder::embed(std::size_t frame, const ShapePoint& target,
                               const Points& place) const
{
    Embedding made = embed(frame, target);
    made.points = best_rigid_motion(made.points, place)(made.points);
    return made;
}

Embedding FrameEmbedder::embed(std::size_t frame, const ShapePoint& target) const
{
    if (!motion_)
        return alone_.embed(target);
    if (frame >= along_->places.size())
        throw InvalidInput(join("frame ", frame, " of a path of ", along_->places.size()));
    const double t = along_->places[frame];
    const std::vector<double>& stations = along_->path.stations;
    return t < stations.front() || t > stations.back() ? alone_.embed(target) : motion_->embed(t);
}

} // namespace shape::internal
