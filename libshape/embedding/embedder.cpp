// SPDX-License-Identifier: MIT

#include "libshape/embedding/embedder.h"

#include <chrono>
#include <mutex>
#include <optional>
#include <utility>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/edge_space/admissibility.h"
#include "libshape/embedding/closure/closure_embedding.h"
#include "libshape/embedding/dihedral/dihedral_embedding.h"
#include "libshape/embedding/multiscale/multiscale_embedding.h"
#include "libshape/embedding/start/face_layout.h"
#include "libshape/mesh/alignment.h"
#include "libshape/mesh/dihedral_angles.h"
#include "libshape/mesh/edge_lengths.h"

namespace shape {
using namespace internal;
namespace {

double seconds_since(std::chrono::steady_clock::time_point start)
{
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// E of Rojas 2014, eq. 3.
double closure_energy(const Topology& topology, const ShapePoint& target)
{
    const FaceLayout layout =
        lay_out_faces(topology, positive_lengths(target.edge_lengths), target.dihedral_angles);
    return (4.0 * (1.0 - closure_angles(topology, layout.transitions).array().cos())).sum();
}

} // namespace

Embedding as_embedding(const Topology& topology, Points points)
{
    points.rowwise() -= centroid(points);
    const ShapePoint target{edge_lengths(topology, points), dihedral_angles(topology, points)};
    Embedding embedding{std::move(points), {}};
    embedding.report = measure_embedding(topology, embedding.points, target);
    embedding.report.closure_energy = closure_energy(topology, target);
    embedding.report.converged = true;
    return embedding;
}

struct Embedder::State
{
    Topology topology;
    std::vector<Points> references;
    EmbeddingOptions options;

    // What prepare() makes.
    std::once_flag prepared;
    std::optional<DihedralEmbedder> dihedral;
    std::optional<MultiscaleEmbedder> multiscale;
    double setup_seconds = 0.0;

    State(const Topology& of, std::vector<Points> near, const EmbeddingOptions& by)
        : topology(of), references(std::move(near)), options(by)
    {
    }

    void prepare()
    {
        std::call_once(prepared, [this] {
            const auto start = std::chrono::steady_clock::now();
            if (options.method == EmbeddingMethod::Multiscale)
                multiscale.emplace(
                    topology, references.front(),
                    MultiscaleOptions{.seed = options.seed,
                                      .registration = {.start = options.registration_start}});
            if (options.method == EmbeddingMethod::Dihedral)
                dihedral.emplace(topology, references);
            setup_seconds = seconds_since(start);
        });
    }
};

Embedder::Embedder(const Topology& topology, std::vector<Points> references,
                   const EmbeddingOptions& options)
{
    if (references.empty())
        throw InvalidInput("the embedding needs at least one reference mesh");
    for (const Points& reference : references) {
        if (reference.rows() != topology.vertex_count())
            throw InvalidInput(join("reference has ", reference.rows(), " rows, the topology ",
                                    topology.vertex_count(), " vertices"));
        if (!(edge_lengths(topology, reference).minCoeff() > 0.0))
            throw InvalidInput("a reference mesh has an edge of length 0");
    }
    if (!(options.smoothness > 0.0))
        throw InvalidInput(join("smoothness is ", options.smoothness, ", must be > 0"));
    state_ = std::make_unique<State>(topology, std::move(references), options);
}

Embedder::~Embedder() = default;
Embedder::Embedder(Embedder&&) noexcept = default;
Embedder& Embedder::operator=(Embedder&&) noexcept = default;

Embedding Embedder::embed(const ShapePoint& target) const
{
    State& s = *state_;
    s.prepare();
    const auto start = std::chrono::steady_clock::now();
    Points points;
    EmbeddingReport solver; // the fields that measure_embedding() leaves open
    std::optional<MultiscaleTimes> multiscale;
    switch (s.options.method) {
        case EmbeddingMethod::Dihedral: {
            DihedralEmbeddingOptions options;
            if (s.options.quality == EmbeddingQuality::Preview)
                options = dihedral_preview();
            options.smoothness = s.options.smoothness;
            DihedralEmbedding nearest = s.dihedral->embed(target, options);
            points = std::move(nearest.points);
            solver.iterations = nearest.iterations;
            solver.converged = nearest.converged;
            break;
        }
        case EmbeddingMethod::Closure: {
            ClosureEmbedding closed = embed_by_closure(s.topology, target);
            points = std::move(closed.points);
            solver.iterations = closed.solution.iterations;
            solver.converged = closed.solution.converged;
            solver.closure_energy = closed.solution.energy;
            break;
        }
        case EmbeddingMethod::Multiscale: {
            MultiscaleEmbedding pose = s.multiscale->embed(target);
            points = std::move(pose.points);
            multiscale = {s.multiscale->setup_times(), pose.times};
            solver.converged = true; // a fixed number of passes
            break;
        }
    }
    points = best_rigid_motion(points, s.references.front())(points);
    points.rowwise() -= centroid(points);
    const double seconds = seconds_since(start);

    Embedding embedding{points, measure_embedding(s.topology, points, target), multiscale};
    embedding.report.closure_energy = s.options.method == EmbeddingMethod::Closure
                                          ? solver.closure_energy
                                          : closure_energy(s.topology, target);
    embedding.report.iterations = solver.iterations;
    embedding.report.converged = solver.converged;
    embedding.report.seconds = seconds;
    embedding.report.setup_seconds = s.setup_seconds;
    return embedding;
}

Embedding Embedder::embed(const DecodedShape& shape) const
{
    if (const Points* const points = std::get_if<Points>(&shape))
        return as_embedding(state_->topology, *points);
    return embed(std::get<ShapePoint>(shape));
}

} // namespace shape
