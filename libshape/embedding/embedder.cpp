// SPDX-License-Identifier: MIT

#include "libshape/embedding/embedder.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <iterator>
#include <mutex>
#include <optional>
#include <utility>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/require.h"
#include "libshape/edge_space/admissibility.h"
#include "libshape/embedding/closure/closure.h"
#include "libshape/embedding/closure/closure_embedding.h"
#include "libshape/embedding/dihedral/dihedral_embedding.h"
#include "libshape/embedding/multiscale/multiscale_embedding.h"
#include "libshape/mesh/alignment.h"
#include "libshape/mesh/dihedral_angles.h"
#include "libshape/mesh/edge_lengths.h"
#include "libshape/mesh/face_crossings.h"

namespace shape {
using namespace internal;
namespace {

double seconds_since(std::chrono::steady_clock::time_point start)
{
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// RMS distance of vertices after the best rigid motion, % of the diagonal.
double distance_in_the_large(const Points& points, const Points& companion)
{
    const Points there = best_rigid_motion(companion, points)(companion);
    return 100.0 * std::sqrt((points - there).rowwise().squaredNorm().mean()) /
           bounding_box_diagonal(points);
}

/// E of the target of an embedding, before anything is solved.
double closure_energy_of(const Topology& topology, const ShapePoint& target)
{
    return closure_energy(topology, positive_lengths(target.edge_lengths), target.dihedral_angles);
}

/// @param known  Sorted: pairs that are not new.
void set_crossings(const FaceTree& tree, const std::vector<FacePair>& known, Embedding& embedding)
{
    const std::vector<FacePair> pairs = tree.crossings(embedding.points);
    std::vector<FacePair> fresh;
    std::set_difference(pairs.begin(), pairs.end(), known.begin(), known.end(),
                        std::back_inserter(fresh));
    embedding.report.self_intersections = static_cast<int>(pairs.size());
    embedding.report.new_self_intersections = static_cast<int>(fresh.size());
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
    set_crossings(FaceTree(topology, embedding.points), {}, embedding);
    return embedding;
}

void check(const EmbeddingOptions& options)
{
    const auto belongs_to = [&](EmbeddingMethod method, const char* name, const char* field,
                                bool is_set) {
        if (is_set && options.method != method)
            throw InvalidInput(join("EmbeddingOptions.", field,
                                    " is set, but belongs to the method ", name,
                                    ", which is not the chosen one"));
    };
    belongs_to(EmbeddingMethod::Dihedral, "Dihedral", "quality", options.quality.has_value());
    belongs_to(EmbeddingMethod::Dihedral, "Dihedral", "smoothness", options.smoothness.has_value());
    belongs_to(EmbeddingMethod::Dihedral, "Dihedral", "anchor", options.anchor.has_value());
    belongs_to(EmbeddingMethod::Multiscale, "Multiscale", "registration_start",
               options.registration_start.has_value());
    belongs_to(EmbeddingMethod::Multiscale, "Multiscale", "seed", options.seed.has_value());
    require_positive(options.smoothness.value_or(default_smoothness),
                     "EmbeddingOptions.smoothness");
    require_not_negative(options.anchor.value_or(default_anchor), "EmbeddingOptions.anchor");
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

    // What reports alone need.
    std::once_flag tree_made;
    std::optional<FaceTree> faces;
    std::vector<FacePair> known_crossings; // of any reference

    State(const Topology& of, std::vector<Points> near, const EmbeddingOptions& by)
        : topology(of), references(std::move(near)), options(by)
    {
    }

    [[nodiscard]] MultiscaleOptions multiscale_options() const
    {
        MultiscaleOptions chosen;
        chosen.seed = options.seed.value_or(chosen.seed);
        chosen.registration.start = options.registration_start.value_or(chosen.registration.start);
        return chosen;
    }

    void make_tree()
    {
        std::call_once(tree_made, [this] {
            faces.emplace(topology, references.front());
            for (const Points& reference : references) {
                const std::vector<FacePair> pairs = faces->crossings(reference);
                known_crossings.insert(known_crossings.end(), pairs.begin(), pairs.end());
            }
            std::sort(known_crossings.begin(), known_crossings.end());
        });
    }

    void prepare()
    {
        std::call_once(prepared, [this] {
            const auto start = std::chrono::steady_clock::now();
            if (options.method == EmbeddingMethod::Multiscale)
                multiscale.emplace(topology, references.front(), multiscale_options());
            if (options.method == EmbeddingMethod::Dihedral)
                dihedral.emplace(topology, references);
            setup_seconds = seconds_since(start);
        });
    }
};

Embedder::Embedder(const Topology& topology, std::vector<Points> references,
                   const EmbeddingOptions& options)
{
    check(options);
    if (references.empty())
        throw InvalidInput("the embedding needs at least one reference mesh");
    for (const Points& reference : references) {
        if (reference.rows() != topology.vertex_count())
            throw InvalidInput(join("reference has ", reference.rows(), " rows, the topology ",
                                    topology.vertex_count(), " vertices"));
        if (!(edge_lengths(topology, reference).minCoeff() > 0.0))
            throw InvalidInput("a reference mesh has an edge of length 0");
    }
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
    Points companion;       // none if the target has no turns
    EmbeddingReport solver; // the fields that measure_embedding() leaves open
    std::optional<MultiscaleTimes> multiscale;
    switch (s.options.method) {
        case EmbeddingMethod::Dihedral: {
            DihedralEmbeddingOptions options;
            if (s.options.quality == EmbeddingQuality::Preview)
                options = dihedral_preview();
            options.smoothness = s.options.smoothness.value_or(default_smoothness);
            options.anchor = s.options.anchor.value_or(default_anchor);
            DihedralEmbedding nearest = s.dihedral->embed(target, options);
            points = std::move(nearest.points);
            companion = std::move(nearest.companion);
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
                                          : closure_energy_of(s.topology, target);
    if (companion.rows() > 0)
        embedding.report.companion_rms = distance_in_the_large(points, companion);
    state_->make_tree();
    set_crossings(*s.faces, s.known_crossings, embedding);
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
