// SPDX-License-Identifier: MIT

#include "libshape/embedding/embedder.h"

#include <chrono>
#include <mutex>
#include <optional>
#include <utility>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/require.h"
#include "libshape/edge_space/admissibility.h"
#include "libshape/embedding/closure/closure_embedding.h"
#include "libshape/embedding/contact_avoidance.h"
#include "libshape/embedding/crossing_count.h"
#include "libshape/embedding/dihedral/dihedral_embedding.h"
#include "libshape/embedding/finished_embedding.h"
#include "libshape/embedding/multiscale/multiscale_embedding.h"
#include "libshape/embedding/target_size.h"
#include "libshape/mesh/dihedral_angles.h"
#include "libshape/mesh/edge_lengths.h"
#include "libshape/mesh/working_unit.h"

namespace shape {
using namespace internal;
namespace {

// Stated twice, since a public header does not include an internal one.
static_assert(default_smoothness == DihedralEmbeddingOptions{}.smoothness);
static_assert(default_anchor == DihedralEmbeddingOptions{}.anchor);
static_assert(default_position_anchor == DihedralEmbeddingOptions{}.position_anchor);

} // namespace

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
    /// working_unit() of the first reference; a mesh in here is this times the mesh as it is.
    double unit;
    std::vector<Points> references;
    EmbeddingOptions options;

    // What prepare() makes.
    std::once_flag dihedral_prepared;
    std::once_flag multiscale_prepared;
    std::optional<DihedralEmbedder> dihedral;
    std::optional<MultiscaleEmbedder> multiscale;
    double dihedral_seconds = 0.0;
    double multiscale_seconds = 0.0;

    CrossingCount crossings;
    ContactAvoidance contacts;

    State(const Topology& of, std::vector<Points> near, const EmbeddingOptions& by)
        : topology(of),
          unit(working_unit(of, near.front())),
          references(in_unit(std::move(near))),
          options(by),
          crossings(topology, references),
          contacts(topology, references, crossings, by.smoothness.value_or(default_smoothness))
    {
    }

    [[nodiscard]] std::vector<Points> in_unit(std::vector<Points> meshes) const
    {
        for (Points& mesh : meshes)
            mesh *= unit;
        return meshes;
    }

    /// Moves faces apart if that is asked for.
    /// @return What avoidable_self_intersections becomes.
    std::optional<int> avoid_contact(Points& points, const ShapePoint& target)
    {
        if (!options.avoid_contact)
            return std::nullopt;
        ContactAvoidance::Result apart = contacts.apart(points, target);
        points = std::move(apart.points);
        return apart.pairs_before;
    }

    [[nodiscard]] MultiscaleOptions multiscale_options() const
    {
        MultiscaleOptions chosen;
        chosen.seed = options.seed.value_or(chosen.seed);
        chosen.registration.start = options.registration_start.value_or(chosen.registration.start);
        return chosen;
    }

    void prepare(EmbeddingMethod method)
    {
        const Clock::time_point start = Clock::now();
        if (method == EmbeddingMethod::Multiscale)
            std::call_once(multiscale_prepared, [&] {
                multiscale.emplace(topology, references.front(), multiscale_options());
                multiscale_seconds = seconds_since(start);
            });
        if (method == EmbeddingMethod::Dihedral)
            std::call_once(dihedral_prepared, [&] {
                dihedral.emplace(topology, references);
                dihedral_seconds = seconds_since(start);
            });
    }

    [[nodiscard]] double setup_seconds(EmbeddingMethod method) const
    {
        switch (method) {
            case EmbeddingMethod::Dihedral:
                return dihedral_seconds;
            case EmbeddingMethod::Multiscale:
                return multiscale_seconds;
            case EmbeddingMethod::Closure:
                break;
        }
        return 0.0;
    }
};

namespace {

/// Methods that glue triangles together cannot start where one has sides that no triangle has.
EmbeddingMethod method_for(EmbeddingMethod chosen, const Topology& topology,
                           const ShapePoint& target)
{
    if (chosen == EmbeddingMethod::Dihedral ||
        target.edge_lengths.size() != topology.edge_count() || !target.edge_lengths.allFinite() ||
        check_admissibility(topology, target.edge_lengths).triangles.empty())
        return chosen;
    return EmbeddingMethod::Dihedral;
}

} // namespace

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
        const Eigen::VectorXd lengths = edge_lengths(topology, reference);
        if (!(lengths.minCoeff() > 0.0))
            throw InvalidInput("a reference mesh has an edge of length 0");
        check_size(lengths.maxCoeff(), "a reference mesh");
    }
    state_ = std::make_unique<State>(topology, std::move(references), options);
}

Embedder::~Embedder() = default;
Embedder::Embedder(Embedder&&) noexcept = default;
Embedder& Embedder::operator=(Embedder&&) noexcept = default;

Embedding Embedder::embed(const ShapePoint& target) const
{
    State& s = *state_;
    if (target.edge_lengths.size() > 0)
        check_size(target.edge_lengths.cwiseAbs().maxCoeff(), "the target");
    ShapePoint wanted = target; // in the working unit
    wanted.edge_lengths *= s.unit;
    wanted.positions *= s.unit;
    const EmbeddingMethod method = method_for(s.options.method, s.topology, wanted);
    s.prepare(method);
    const Clock::time_point start = Clock::now();
    const Points& reference = s.references.front();
    Embedding embedding;
    std::optional<int> avoidable;
    switch (method) {
        case EmbeddingMethod::Dihedral: {
            DihedralEmbeddingOptions options;
            if (s.options.quality == EmbeddingQuality::Preview)
                options = dihedral_preview();
            options.smoothness = s.options.smoothness.value_or(default_smoothness);
            options.anchor = s.options.anchor.value_or(default_anchor);
            options.position_anchor = s.options.anchor.value_or(default_position_anchor);
            DihedralEmbedding nearest = s.dihedral->embed(wanted, options);
            avoidable = s.avoid_contact(nearest.points, wanted);
            embedding = finished_embedding(s.topology, nearest, reference, wanted, start);
            break;
        }
        case EmbeddingMethod::Closure: {
            ClosureEmbedding closed = embed_by_closure(s.topology, wanted);
            avoidable = s.avoid_contact(closed.points, wanted);
            embedding = finished_embedding(s.topology, closed.points, reference, wanted, start);
            embedding.report.iterations = closed.solution.iterations;
            embedding.report.converged = closed.solution.converged;
            embedding.report.closure_energy = closed.solution.energy;
            break;
        }
        case EmbeddingMethod::Multiscale: {
            MultiscaleEmbedding pose = s.multiscale->embed(wanted);
            avoidable = s.avoid_contact(pose.points, wanted);
            embedding = finished_embedding(s.topology, pose.points, reference, wanted, start);
            embedding.multiscale = {s.multiscale->setup_times(), pose.times};
            embedding.report.converged = true; // a fixed number of passes
            break;
        }
    }
    if (method != s.options.method)
        embedding.instead = method;
    embedding.report.setup_seconds = s.setup_seconds(method);
    s.crossings.add_to(embedding);
    embedding.report.avoidable_self_intersections = avoidable;
    embedding.points /= s.unit;
    return embedding;
}

Embedding Embedder::embed(const DecodedShape& shape) const
{
    if (const Points* const whole = std::get_if<Points>(&shape)) {
        State& s = *state_;
        const Points points = s.unit * *whole;
        Embedding embedding = as_embedding(s.topology, points);
        if (s.options.avoid_contact) {
            const Clock::time_point start = Clock::now();
            const ShapePoint own{edge_lengths(s.topology, points),
                                 dihedral_angles(s.topology, points)};
            Points moved = points;
            const std::optional<int> avoidable = s.avoid_contact(moved, own);
            if (moved != points) {
                embedding = finished_embedding(s.topology, moved, points, own, start);
                embedding.report.converged = true;
            }
            embedding.report.avoidable_self_intersections = avoidable;
        }
        s.crossings.add_to(embedding);
        embedding.points /= s.unit;
        return embedding;
    }
    return embed(std::get<ShapePoint>(shape));
}

} // namespace shape
