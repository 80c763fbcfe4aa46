// SPDX-License-Identifier: MIT

#include "libshape/embedding/embedder.h"

#include <chrono>
#include <optional>
#include <utility>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/embedding/closure_embedding.h"
#include "libshape/embedding/dihedral_embedding.h"
#include "libshape/embedding/multiscale_embedding.h"

namespace shape {
namespace {

double seconds_since(std::chrono::steady_clock::time_point start)
{
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

} // namespace

struct Embedder::State
{
    Topology topology;
    Points reference;
    EmbeddingOptions options;
    std::optional<DihedralEmbedder> dihedral;
    std::optional<MultiscaleEmbedder> multiscale;
    double setup_seconds = 0.0;
};

Embedder::Embedder(const Topology& topology, std::vector<Points> references,
                   const EmbeddingOptions& options)
{
    const auto start = std::chrono::steady_clock::now();
    if (references.empty())
        throw InvalidInput("the embedding needs at least one reference mesh");
    for (const Points& reference : references)
        if (reference.rows() != topology.vertex_count())
            throw InvalidInput(join("reference has ", reference.rows(), " rows, the topology ",
                                    topology.vertex_count(), " vertices"));
    if (!(options.smoothness > 0.0))
        throw InvalidInput(join("smoothness is ", options.smoothness, ", must be > 0"));
    state_ = std::make_unique<State>(State{topology, references.front(), options, {}, {}, 0.0});
    if (options.method == EmbeddingMethod::Multiscale)
        state_->multiscale.emplace(
            topology, references.front(),
            MultiscaleOptions{.seed = options.seed,
                              .registration = {.start = options.registration_start}});
    if (options.method == EmbeddingMethod::Dihedral)
        state_->dihedral.emplace(topology, references);
    state_->setup_seconds = seconds_since(start);
}

Embedder::~Embedder() = default;
Embedder::Embedder(Embedder&&) noexcept = default;
Embedder& Embedder::operator=(Embedder&&) noexcept = default;

Embedding Embedder::embed(const ShapePoint& target) const
{
    const auto start = std::chrono::steady_clock::now();
    const State& s = *state_;
    Embedding embedding;
    switch (s.options.method) {
        case EmbeddingMethod::Dihedral: {
            DihedralEmbeddingOptions options;
            if (s.options.quality == EmbeddingQuality::Preview)
                options = dihedral_preview();
            options.smoothness = s.options.smoothness;
            embedding = embed_by_dihedrals(*s.dihedral, s.topology, s.reference, target, options);
            break;
        }
        case EmbeddingMethod::Closure: {
            const ClosureEmbedding closed = embed_by_closure(s.topology, target);
            embedding = finished_embedding(s.topology, closed.points, s.reference, target);
            embedding.report.iterations = closed.solution.iterations;
            embedding.report.converged = closed.solution.converged;
            embedding.report.closure_energy = closed.solution.energy;
            break;
        }
        case EmbeddingMethod::Multiscale: {
            const MultiscaleEmbedding pose = s.multiscale->embed(target);
            embedding = finished_embedding(s.topology, pose.points, s.reference, target);
            embedding.multiscale = {s.multiscale->setup_times(), pose.times};
            embedding.report.converged = true; // a fixed number of passes
            break;
        }
    }
    embedding.report.seconds = seconds_since(start);
    embedding.report.setup_seconds = s.setup_seconds;
    return embedding;
}

double Embedder::setup_seconds() const
{
    return state_->setup_seconds;
}

} // namespace shape
