// SPDX-License-Identifier: MIT

#include "libshape/model/model_quality.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>
#include <optional>
#include <tuple>
#include <utility>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/random.h"
#include "libshape/base/require.h"
#include "libshape/base/threads.h"
#include "libshape/base/to_size.h"
#include "libshape/edge_space/procrustes.h"
#include "libshape/mesh/alignment.h"
#include "libshape/mesh/edge_lengths.h"
#include "libshape/model/shape_model.h"

namespace shape {
using namespace internal;
namespace {

using Eigen::Index;

/// The numbers 0 to count - 1 in random order (Fisher and Yates).
std::vector<int> shuffled(Index count, Random& random)
{
    std::vector<int> order(to_size(count));
    std::iota(order.begin(), order.end(), 0);
    for (std::size_t i = order.size(); i > 1; --i)
        std::swap(order[i - 1], order[random.index(i)]);
    return order;
}

/// Where the meshes come from: memory, or a stream.
struct MeshSource
{
    using Indices = std::vector<std::size_t>;

    Topology topology;
    std::size_t count = 0;
    std::function<ShapeModel(const Indices& some, const ModelOptions& options)> fit;
    std::function<Collection(const Indices& some)> read;
    /// All meshes once, in their order.
    std::function<void(const std::function<void(const Collection& block)>& visit)> for_each_block;
    Ranks ranks = {};
};

MeshSource source_of(const Collection& collection)
{
    return {collection.topology,
            collection.size(),
            [&](const MeshSource::Indices& some, const ModelOptions& options) {
                const bool is_all = some.size() == collection.size();
                return is_all ? fit_model(collection, options)
                              : fit_model(subset(collection, some), options);
            },
            [&](const MeshSource::Indices& some) { return subset(collection, some); },
            [&](const auto& visit) { visit(collection); },
            {}};
}

MeshSource source_of(const MeshStream& meshes, const StreamOptions& stream)
{
    constexpr Index block = 32;
    return {meshes.topology,
            to_size(meshes.size()),
            [&](const MeshSource::Indices& some, const ModelOptions& options) {
                StreamOptions own;
                own.memory = stream.memory;
                own.algorithm = stream.algorithm;
                own.tolerance = stream.tolerance;
                own.seed = stream.seed;
                own.scratch = stream.scratch;
                own.ranks = stream.ranks;
                return fit_model(subset(meshes, some), options, own).model;
            },
            [&](const MeshSource::Indices& some) {
                MeshSource::Indices ascending = some; // as meshes of a stream come
                std::ranges::sort(ascending);
                const MeshStream chosen = subset(meshes, ascending);
                Collection read{chosen.topology, chosen.names, {}, chosen.labels};
                for_each_block(chosen, 0, chosen.size(), block, [&](Index, const Collection& part) {
                    read.points.insert(read.points.end(), part.points.begin(), part.points.end());
                });
                MeshSource::Indices places;
                for (const std::size_t mesh : some)
                    places.push_back(
                        to_size(std::ranges::lower_bound(ascending, mesh) - ascending.begin()));
                return subset(read, places);
            },
            [&](const auto& visit) {
                for_each_block(meshes, 0, meshes.size(), block,
                               [&](Index, const Collection& part) { visit(part); });
            },
            stream.ranks};
}

void check_folds(const MeshSource& meshes, const Grouping& folds)
{
    if (folds.size() != static_cast<Index>(meshes.count) || folds.group_count() < 2)
        throw InvalidInput(join("quality: ", folds.size(), " meshes in ", folds.group_count(),
                                " folds for ", meshes.count,
                                " meshes; there must be as many meshes and at least 2 folds"));
}

/// A mesh as the measures see it.
struct Measured
{
    Points points; ///< Centred; of the common size if size is taken away.
    Eigen::VectorXd lengths;
};

/// Brings meshes to one size and measures between them.
class Ruler
{
public:
    Ruler(const MeshSource& meshes, Scale scale) : topology_(meshes.topology), scale_(scale)
    {
        meshes.for_each_block([&](const Collection& block) {
            for (const Points& points : block.points)
                size_ += centroid_size(points) / static_cast<double>(meshes.count);
        });
    }

    [[nodiscard]] Measured operator()(const Points& points) const
    {
        Measured mesh{points.rowwise() - points.colwise().mean(), edge_lengths(topology_, points)};
        if (scale_ == Scale::Unit) {
            mesh.points *= size_ / mesh.points.norm();
            mesh.lengths /= mesh.lengths.sum();
        }
        return mesh;
    }

private:
    Topology topology_;
    Scale scale_;
    double size_ = 0.0;
};

double vertex_distance(const Measured& mesh, const Measured& truth)
{
    const Eigen::Matrix3d rotation =
        nearest_rotation(Eigen::Matrix3d(truth.points.transpose() * mesh.points));
    return (mesh.points * rotation.transpose() - truth.points).norm() /
           std::sqrt(static_cast<double>(truth.points.rows()));
}

double edge_distance(const Measured& mesh, const Measured& truth)
{
    return (mesh.lengths - truth.lengths).norm() /
           std::sqrt(static_cast<double>(truth.lengths.size())) / truth.lengths.mean();
}

/// Mean and standard deviation of the columns.
QualityCurve summarise(const Eigen::MatrixXd& values)
{
    const Eigen::RowVectorXd mean = values.colwise().mean();
    const double divisor = std::max<double>(1.0, static_cast<double>(values.rows() - 1));
    const Eigen::RowVectorXd squares = (values.rowwise() - mean).colwise().squaredNorm();
    return {mean.transpose(), (squares / divisor).cwiseSqrt().transpose()};
}

/// A model has fewer modes than are wanted.
class FewerModes : public InvalidInput
{
public:
    FewerModes(int wanted, int found, const std::string& of)
        : InvalidInput(join("quality: ", wanted, " modes are more than the ", found, of)),
          found_(found)
    {
    }
    [[nodiscard]] int found() const { return found_; }

private:
    int found_;
};

/// @param what  Names the meshes.
/// @throws FewerModes
ShapeModel fit(const MeshSource& meshes, const MeshSource::Indices& some,
               const QualityOptions& options, const std::string& what)
{
    const int most = options.modes.back();
    if (const int all = static_cast<int>(some.size()) - 1; most > all)
        throw FewerModes(most, all, join(" of a model of ", what));
    ShapeModel model = meshes.fit(some, {.modes = most, .space = options.space});
    if (model.mode_count() < most)
        throw FewerModes(most, model.mode_count(), join(" with any variance of a model of ", what));
    return model;
}

/// Decodes points of models into meshes, several at a time, each process every count-th row of scores.
class Decoder
{
public:
    Decoder(const QualityOptions& options, const Ranks& ranks, const Progress& progress, int total)
        : options_(options),
          ranks_(ranks),
          progress_(progress),
          total_(to_size(total / ranks.count))
    {
    }

    [[nodiscard]] bool is_own(Index row) const { return row % ranks_.count == ranks_.number; }

    /// One mesh for every row of scores and every number of modes, rows first; none of rows that are not
    /// this process's own.
    std::vector<Points> operator()(const ShapeModel& model, const RowMatrix& scores,
                                   const Eigen::VectorXd& sizes)
    {
        if (!(embedder_ && reference_ == model.reference_points)) {
            reference_ = model.reference_points;
            embedder_.emplace(model.topology, std::vector<Points>{reference_}, options_.embedding);
        }
        const std::size_t counts = options_.modes.size();
        std::vector<Points> meshes(to_size(scores.rows()) * counts);
        std::atomic<int> nearest = 0;
        for (Index row = 0; row < scores.rows(); ++row) {
            if (!is_own(row))
                continue;
            if (progress_)
                progress_("decoding", to_size(decoded), std::max(total_, to_size(decoded)));
            parallel_for(counts, 1, [&](std::size_t k, std::size_t) {
                const Eigen::VectorXd first = scores.row(row).head(options_.modes[k]).transpose();
                Embedding embedding = embedder_->embed(model_point(model, first, sizes[row]));
                nearest += embedding.report.status == EmbeddingStatus::Infeasible ? 1 : 0;
                meshes[to_size(row) * counts + k] = std::move(embedding.points);
            });
            decoded += static_cast<int>(counts);
        }
        infeasible += nearest;
        return meshes;
    }

    /// Meshes decoded, and those of infeasible lengths among them, of all processes.
    [[nodiscard]] std::pair<int, int> counts() const
    {
        std::array<double, 2> sums{static_cast<double>(decoded), static_cast<double>(infeasible)};
        ranks_.all_reduce_sum(sums);
        return {static_cast<int>(sums[0]), static_cast<int>(sums[1])};
    }

    int decoded = 0;
    int infeasible = 0;

private:
    const QualityOptions& options_;
    const Ranks& ranks_;
    const Progress& progress_;
    std::size_t total_;
    Points reference_;
    std::optional<Embedder> embedder_;
};

void measure_generalisation(const MeshSource& meshes, const Grouping& folds,
                            const QualityOptions& options, const Ruler& ruler,
                            const std::vector<int>& tests, Decoder& decode, ModelQuality& quality)
{
    const auto counts = static_cast<Index>(options.modes.size());
    Eigen::MatrixXd vertex = Eigen::MatrixXd::Zero(static_cast<Index>(tests.size()), counts);
    Eigen::MatrixXd edge = vertex;
    Index row = 0;
    for (int fold = 0; fold < folds.group_count(); ++fold) {
        MeshSource::Indices left_out;
        MeshSource::Indices others;
        for (const int mesh : tests)
            if (folds.group_of[to_size(mesh)] == fold)
                left_out.push_back(to_size(mesh));
        if (left_out.empty())
            continue;
        for (std::size_t mesh = 0; mesh < meshes.count; ++mesh)
            if (folds.group_of[mesh] != fold)
                others.push_back(mesh);
        const ShapeModel model =
            fit(meshes, others, options, join("all meshes but fold ", fold + 1));
        const Collection tested = meshes.read(left_out);
        const Projection projection = project(model, tested);
        const std::vector<Points> decoded = decode(model, projection.scores, projection.sizes);
        for (std::size_t i = 0; i < left_out.size(); ++i, ++row) {
            if (!decode.is_own(static_cast<Index>(i)))
                continue;
            const Measured truth = ruler(tested.points[i]);
            for (Index k = 0; k < counts; ++k) {
                const Measured mesh = ruler(decoded[i * to_size(counts) + to_size(k)]);
                vertex(row, k) = vertex_distance(mesh, truth);
                edge(row, k) = edge_distance(mesh, truth);
            }
        }
    }
    for (Eigen::MatrixXd* distances : {&vertex, &edge})
        meshes.ranks.all_reduce_sum({distances->data(), to_size(distances->size())});
    quality.generalisation_vertex = summarise(vertex);
    quality.generalisation_edge = summarise(edge);
}

/// Lowers the distances of samples to the nearest mesh by those to the meshes of a block.
void lower_distances(const Collection& block, const Ruler& ruler,
                     const std::vector<Measured>& samples, Eigen::VectorXd& vertex,
                     Eigen::VectorXd& edge)
{
    // One slot a chunk of the block: the minimum over them does not depend on their order.
    constexpr std::size_t grain = 16;
    const auto total = static_cast<Index>(samples.size());
    const auto chunks = static_cast<Index>((block.size() + grain - 1) / grain);
    Eigen::MatrixXd vertices = vertex.replicate(1, chunks);
    Eigen::MatrixXd edges = edge.replicate(1, chunks);
    parallel_for(block.size(), grain, [&](std::size_t begin, std::size_t end) {
        const auto chunk = static_cast<Index>(begin / grain);
        for (std::size_t i = begin; i < end; ++i) {
            const Measured truth = ruler(block.points[i]);
            for (Index s = 0; s < total; ++s) {
                const Measured& sample = samples[to_size(s)];
                vertices(s, chunk) = std::min(vertices(s, chunk), vertex_distance(sample, truth));
                edges(s, chunk) = std::min(edges(s, chunk), edge_distance(sample, truth));
            }
        }
    });
    vertex = vertices.rowwise().minCoeff();
    edge = edges.rowwise().minCoeff();
}

/// Distances of samples to the nearest mesh.
/// @param decoded  Empty where another process has the sample.
void measure_specificity(const MeshSource& meshes, const Ruler& ruler,
                         const std::vector<Points>& decoded, Index counts, ModelQuality& quality)
{
    std::vector<Measured> samples;
    MeshSource::Indices places;
    for (std::size_t i = 0; i < decoded.size(); ++i) {
        if (decoded[i].size() == 0)
            continue;
        samples.push_back(ruler(decoded[i]));
        places.push_back(i);
    }
    const auto total = static_cast<Index>(samples.size());
    Eigen::VectorXd vertex =
        Eigen::VectorXd::Constant(total, std::numeric_limits<double>::infinity());
    Eigen::VectorXd edge = vertex;
    meshes.for_each_block(
        [&](const Collection& block) { lower_distances(block, ruler, samples, vertex, edge); });
    const auto curve = [&](const Eigen::VectorXd& own) {
        Eigen::VectorXd nearest = Eigen::VectorXd::Zero(static_cast<Index>(decoded.size()));
        nearest(places) = own;
        meshes.ranks.all_reduce_sum({nearest.data(), decoded.size()});
        return summarise(nearest.reshaped<Eigen::RowMajor>(nearest.size() / counts, counts));
    };
    quality.specificity_vertex = curve(vertex);
    quality.specificity_edge = curve(edge);
}

ModelQuality measure_at(const MeshSource& meshes, const Grouping& folds,
                        const QualityOptions& options, const Progress& progress)
{
    Random random(options.seed);
    std::vector<int> tests = shuffled(static_cast<Index>(meshes.count), random);
    tests.resize(std::min(tests.size(), to_size(options.tests)));
    const auto counts = static_cast<Index>(options.modes.size());
    ModelQuality quality;
    quality.modes = options.modes;
    quality.tests = static_cast<int>(tests.size());
    const Ruler ruler(meshes, options.space.scale);
    Decoder decode(options, meshes.ranks, progress,
                   (quality.tests + options.samples) * static_cast<int>(counts));
    measure_generalisation(meshes, folds, options, ruler, tests, decode, quality);

    MeshSource::Indices all(meshes.count);
    std::iota(all.begin(), all.end(), std::size_t{0});
    const ShapeModel model = fit(meshes, all, options, "all meshes");
    quality.compactness.resize(counts);
    for (Index k = 0; k < counts; ++k)
        quality.compactness[k] =
            model.variances.head(options.modes[to_size(k)]).sum() / model.total_variance;
    RowMatrix scores(options.samples, model.mode_count());
    for (double& score : scores.reshaped<Eigen::RowMajor>())
        score = random.normal();
    scores *= model.variances.cwiseSqrt().asDiagonal();
    const std::vector<Points> samples =
        decode(model, scores, Eigen::VectorXd::Constant(options.samples, model.mean_size()));
    measure_specificity(meshes, ruler, samples, counts, quality);
    std::tie(quality.decoded, quality.infeasible) = decode.counts();
    return quality;
}

/// The most modes that meshes without the largest fold can have.
int most_modes(const Grouping& folds)
{
    std::size_t largest = 0;
    for (const std::vector<int>& fold : members(folds))
        largest = std::max(largest, fold.size());
    return static_cast<int>(folds.size()) - static_cast<int>(largest) - 1;
}

ModelQuality measure(const MeshSource& meshes, const Grouping& folds, const QualityOptions& options,
                     const Progress& progress)
{
    check(options);
    check_folds(meshes, folds);
    if (!options.modes.empty())
        return measure_at(meshes, folds, options, progress);
    QualityOptions usual = options;
    for (int most = std::max(1, most_modes(folds));;) {
        usual.modes = usual_mode_counts(most);
        try {
            return measure_at(meshes, folds, usual, progress);
        } catch (const FewerModes& fewer) { // the first model of meshes of low rank says so
            if (fewer.found() < 1)
                throw;
            most = fewer.found();
        }
    }
}

} // namespace

void check(const QualityOptions& options)
{
    check(options.space);
    int last = 0;
    for (std::size_t i = 0; i < options.modes.size(); last = options.modes[i++])
        require(options.modes[i] > last, join("QualityOptions.modes[", i, "]"), options.modes[i],
                join("> ", last, ": ascending and >= 1"));
    require_at_least(1, options.tests, "QualityOptions.tests");
    require_at_least(1, options.samples, "QualityOptions.samples");
    check(options.embedding);
}

ModelQuality measure_quality(const Collection& collection, const Grouping& folds,
                             const QualityOptions& options, const Progress& progress)
{
    return measure(source_of(collection), folds, options, progress);
}

ModelQuality measure_quality(const MeshStream& meshes, const Grouping& folds,
                             const QualityOptions& options, const StreamOptions& stream,
                             const Progress& progress)
{
    check(stream);
    require(!stream.save, "StreamOptions.save", "set", "empty: many models are made");
    require(!stream.state, "StreamOptions.state", "set", "empty: many models are made");
    require(!stream.progress, "StreamOptions.progress", "set", "empty: decoded meshes are counted");
    return measure(source_of(meshes, stream), folds, options, progress);
}

Grouping random_folds(Eigen::Index meshes, int count, std::uint64_t seed)
{
    if (count < 2 || count > meshes)
        throw InvalidInput(join("folds: ", count, " folds of ", meshes,
                                " meshes; there must be at least 2, and not more than meshes"));
    if (count == meshes)
        return groups_of_one(meshes);
    Random random(seed);
    const std::vector<int> order = shuffled(meshes, random);
    Grouping folds{{}, std::vector<int>(order.size())};
    for (int fold = 0; fold < count; ++fold)
        folds.names.push_back(join("fold ", fold + 1));
    for (std::size_t i = 0; i < order.size(); ++i)
        folds.group_of[to_size(order[i])] = static_cast<int>(i) % count;
    return folds;
}

std::vector<int> usual_mode_counts(int most)
{
    std::vector<int> counts;
    for (const int count : {1, 2, 5, 10, 20, 50})
        if (count < most)
            counts.push_back(count);
    if (most <= 50)
        counts.push_back(most);
    return counts;
}

} // namespace shape
