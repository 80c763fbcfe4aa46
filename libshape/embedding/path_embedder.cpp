// SPDX-License-Identifier: MIT

#include "libshape/embedding/path_embedder.h"

#include <algorithm>
#include <chrono>
#include <mutex>
#include <optional>
#include <utility>

#include "libshape/base/error.h"
#include "libshape/embedding/contact_avoidance.h"
#include "libshape/embedding/crossing_count.h"
#include "libshape/embedding/dihedral/coherent_path.h"
#include "libshape/embedding/finished_embedding.h"

namespace shape {
using namespace internal;

struct PathEmbedder::State
{
    Topology topology;
    std::vector<Points> references;
    TargetPath path;
    CoherentPathOptions options;
    Progress progress;
    CrossingCount crossings;
    std::optional<ContactAvoidance> contacts; ///< If asked for.

    std::once_flag solved;
    std::optional<DihedralEmbedder> embedder;
    std::optional<CoherentPath> meshes;
    double setup_seconds = 0.0;

    State(const Topology& of, std::vector<Points> near, TargetPath along, Progress listener)
        : topology(of),
          references(std::move(near)),
          path(std::move(along)),
          progress(std::move(listener)),
          crossings(topology, references)
    {
    }

    void solve()
    {
        std::call_once(solved, [this] {
            const Clock::time_point start = Clock::now();
            embedder.emplace(topology, references);
            meshes.emplace(*embedder, path.target, path.stations, options, progress);
            setup_seconds = seconds_since(start);
        });
    }
};

PathEmbedder::PathEmbedder(const Topology& topology, std::vector<Points> references,
                           TargetPath path, const EmbeddingOptions& options, Progress progress)
{
    check(options);
    if (options.method != EmbeddingMethod::Dihedral ||
        options.quality.value_or(EmbeddingQuality::Fine) != EmbeddingQuality::Fine)
        throw InvalidInput(
            "a path is embedded by EmbeddingMethod::Dihedral and "
            "EmbeddingQuality::Fine alone");
    check_stations(path.stations);
    (void)Embedder(topology, references); // checks the references
    state_ = std::make_unique<State>(topology, std::move(references), std::move(path),
                                     std::move(progress));
    CoherentPathOptions& path_options = state_->options;
    path_options.steps = state_->path.steps;
    path_options.smoothness = options.smoothness.value_or(default_smoothness);
    if (options.avoid_contact)
        state_->contacts.emplace(state_->topology, state_->references, state_->crossings,
                                 path_options.smoothness);
    path_options.anchor = std::min(path_options.anchor, options.anchor.value_or(default_anchor));
    path_options.position_anchor = options.anchor.value_or(default_position_anchor);
    check(path_options);
}

PathEmbedder::~PathEmbedder() = default;
PathEmbedder::PathEmbedder(PathEmbedder&&) noexcept = default;
PathEmbedder& PathEmbedder::operator=(PathEmbedder&&) noexcept = default;

Embedding PathEmbedder::embed(double t) const
{
    State& s = *state_;
    s.solve();
    const Clock::time_point start = Clock::now();
    DihedralEmbedding mesh = s.meshes->at(t);
    const ShapePoint target = s.path.target(t);
    std::optional<int> avoidable;
    if (s.contacts) {
        ContactAvoidance::Result apart = s.contacts->apart(mesh.points, target);
        mesh.points = std::move(apart.points);
        avoidable = apart.pairs_before;
    }
    Embedding embedding = finished_embedding(s.topology, mesh, s.references.front(), target, start);
    embedding.report.setup_seconds = s.setup_seconds;
    s.crossings.add_to(embedding);
    embedding.report.avoidable_self_intersections = avoidable;
    return embedding;
}

} // namespace shape
