// SPDX-License-Identifier: MIT

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>

#include "libshape/base/counted.h"
#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/order_statistics.h"
#include "libshape/base/random.h"
#include "libshape/base/rounded.h"
#include "libshape/base/to_size.h"
#include "libshape/edge_space/admissibility.h"
#include "libshape/io/model_file.h"
#include "libshape/io/table_file.h"
#include "libshape/model/shape_model.h"
#include "tools/commands.h"
#include "tools/output/embedding_run.h"
#include "tools/output/embedding_settings.h"
#include "tools/output/frame_store.h"
#include "tools/output/mesh_output.h"
#include "tools/output/shard.h"
#include "tools/program/arguments.h"
#include "tools/program/session.h"

namespace shape::tools {
using namespace internal;
namespace {

constexpr std::int64_t most_meshes = 1'000'000;
constexpr double most_sigma = 1000.0; ///< [standard deviations]

struct Arguments
{
    std::string model;
    bool mean = false;
    std::int64_t mode = 0;
    std::string sigma;
    std::string scores;
    std::string scores_file;
    std::int64_t samples = 0;
    bool feasible = false; ///< Samples are drawn in until a mesh may have their lengths.
    std::optional<double> size;
    MeshOutputArguments output;
    EmbeddingArguments embedding;
    Shard shard;
};

/// A point of the model and the name of its mesh.
struct ModelPoint
{
    std::string name;
    Eigen::VectorXd scores; ///< Coordinates along the modes.
    double size = 0.0;      ///< [length]
    double share = 1.0;     ///< Of the scores of a sample that --feasible has kept.
    double drawn = 0.0;     ///< |scores|^2 of a sample as it was drawn.
};

Eigen::VectorXd standard_deviations(const ShapeModel& model)
{
    return model.variances.cwiseSqrt();
}

double size_of(const ShapeModel& model, const Arguments& arguments)
{
    return arguments.size.value_or(model.mean_size());
}

/// All points are embedded at the mean size, so that the shape is the same at every size.
DecodedShape shape_of(const ShapeModel& model, const Eigen::VectorXd& scores)
{
    return model_point(model, scores, model.mean_size());
}

/// The N equally spaced values of "A:B:N", or the one of "A" [standard deviations].
std::vector<double> sigma_values(const std::string& text)
{
    const std::vector<std::string> parts = split(text, ':');
    const auto sigma = [](const std::string& part) {
        const double value = read_number(part, "--sigma");
        if (std::abs(value) > most_sigma)
            throw UsageError(
                join("--sigma: ", part, " is out of range [-", most_sigma, ", ", most_sigma, "]"));
        return value;
    };
    if (parts.size() == 1)
        return {sigma(parts[0])};
    if (parts.size() != 3)
        throw UsageError(join("--sigma: '", text, "' must be A:B:N or one number"));
    const double from = sigma(parts[0]);
    const double to = sigma(parts[1]);
    const double count = read_number(parts[2], "--sigma");
    if (count != std::floor(count) || count < 2 || count > static_cast<double>(most_meshes))
        throw UsageError(join("--sigma: the number of steps ", parts[2],
                              " must be an integer in [2, ", most_meshes, "]"));
    std::vector<double> values;
    for (double i = 0; i < count; ++i) {
        values.push_back(from + (to - from) * i / (count - 1.0));
        if (i > 0 && values.back() == values[values.size() - 2])
            throw UsageError(join("--sigma: '", text, "' has the value ", parts[0],
                                  " more than once; for one mesh give `--sigma ", parts[0], "`"));
    }
    return values;
}

/// "mode01_-2.00": two decimals, or as many as it takes to tell the values apart.
std::vector<std::string> mode_names(std::int64_t mode, const std::vector<double>& sigmas)
{
    for (int decimals = 2;; ++decimals) {
        std::vector<std::string> names;
        for (const double sigma : sigmas) {
            char name[400];
            const double value = std::abs(sigma) < 0.5 * std::pow(10.0, -decimals) ? 0.0 : sigma;
            std::snprintf(name, sizeof name, "mode%02d_%.*f", static_cast<int>(mode), decimals,
                          value);
            names.emplace_back(name);
        }
        const bool distinct = std::set(names.begin(), names.end()).size() == names.size();
        if (distinct || decimals == 17)
            return names; // values equal to the last bit are refused as outputs of one name
    }
}

Eigen::VectorXd scores_along(const ShapeModel& model, std::int64_t mode, double sigma)
{
    Eigen::VectorXd scores = Eigen::VectorXd::Zero(mode);
    scores[mode - 1] = sigma * std::sqrt(model.variances[mode - 1]);
    return scores;
}

std::vector<ModelPoint> mode_points(const ShapeModel& model, const Arguments& arguments,
                                    const std::vector<double>& sigmas)
{
    if (arguments.mode > model.mode_count())
        throw InvalidInput(join("--mode: ", arguments.mode, " is out of range, ", arguments.model,
                                " has modes 1 to ", model.mode_count()));
    const std::vector<std::string> names = mode_names(arguments.mode, sigmas);
    std::vector<ModelPoint> points;
    for (std::size_t i = 0; i < sigmas.size(); ++i)
        points.push_back(
            {names[i], scores_along(model, arguments.mode, sigmas[i]), size_of(model, arguments)});
    return points;
}

ModelPoint point_of_scores(const ShapeModel& model, const Arguments& arguments)
{
    const std::vector<double> sigmas = read_numbers(arguments.scores, "--scores");
    const auto count = static_cast<Eigen::Index>(sigmas.size());
    if (count > model.mode_count())
        throw InvalidInput(join("--scores: ", count, " scores, but ", arguments.model, " has ",
                                counted(model.mode_count(), "mode")));
    const Eigen::VectorXd scores = Eigen::Map<const Eigen::VectorXd>(sigmas.data(), count)
                                       .cwiseProduct(standard_deviations(model).head(count));
    return {"scores", scores, size_of(model, arguments)};
}

/// Where each score stands in the table: column of pc1, pc2, ...
std::vector<std::size_t> score_columns(const Table& table, const std::string& file, int modes)
{
    std::vector<std::size_t> columns;
    for (;;) {
        const std::string wanted = join("pc", columns.size() + 1);
        const auto found = std::find(table.columns.begin(), table.columns.end(), wanted);
        if (found == table.columns.end())
            break;
        columns.push_back(to_size(found - table.columns.begin()));
    }
    if (table.columns.front() != "mesh")
        throw InvalidInput(join(file, ": the first column is `", table.columns.front(),
                                "`, must be `mesh`; scores stand in the columns pc1, pc2, ..."));
    if (columns.empty())
        throw InvalidInput(join(file,
                                ": there is no column pc1; scores stand in the columns pc1, "
                                "pc2, ... without a gap, 0 where a score is none"));
    if (columns.size() > to_size(modes))
        throw InvalidInput(
            join(file, ": scores for ", columns.size(), " modes, the model has ", modes));
    for (std::size_t c = 0; c < table.columns.size(); ++c) {
        const std::string& name = table.columns[c];
        const bool is_score = name.size() > 2 && name.starts_with("pc") &&
                              name.find_first_not_of("0123456789", 2) == std::string::npos;
        if (is_score && std::find(columns.begin(), columns.end(), c) == columns.end())
            throw InvalidInput(join(file, ": column '", name, "', but no column 'pc",
                                    columns.size() + 1,
                                    "'; name the columns pc1, pc2, ... without a gap, 0 where a "
                                    "score is none"));
    }
    return columns;
}

std::vector<ModelPoint> points_of_file(const ShapeModel& model, const Arguments& arguments)
{
    const std::string& file = arguments.scores_file;
    const Table table = read_table(file);
    const std::vector<std::size_t> columns = score_columns(table, file, model.mode_count());
    const auto size = std::find(table.columns.begin(), table.columns.end(), "size");
    const bool has_sizes = size != table.columns.end() && !arguments.size;
    const auto size_column = to_size(size - table.columns.begin());
    std::vector<ModelPoint> points;
    for (const std::vector<std::string>& row : table.rows) {
        if (row.front().empty())
            throw InvalidInput(
                join(file, ": row ", points.size() + 1, " has no name in the first column"));
        const std::string place = join(file, ": mesh ", row.front());
        const auto number = [&](std::size_t column) {
            return parse_number(row[column], join(place, ", column ", table.columns[column]));
        };
        Eigen::VectorXd scores(static_cast<Eigen::Index>(columns.size()));
        for (Eigen::Index k = 0; k < scores.size(); ++k)
            scores[k] = number(columns[to_size(k)]);
        points.push_back(
            {row.front(), scores, has_sizes ? number(size_column) : size_of(model, arguments)});
        if (!(points.back().size > 0.0))
            throw InvalidInput(join(place, ": the size ", points.back().size, " must be > 0"));
    }
    if (points.empty())
        throw InvalidInput(join(file, ": the table has no rows"));
    return points;
}

/// The share of the scores with which the point keeps the inequalities of edge lengths: 1 if it does as it is; else 99 %
/// of the way from the mean to their boundary, which is found by halving.
double feasible_share(const ShapeModel& model, const Eigen::VectorXd& scores)
{
    const auto is_feasible = [&](double share) {
        const DecodedShape shape = shape_of(model, share * scores);
        const ShapePoint* const point = std::get_if<ShapePoint>(&shape);
        return point == nullptr ||
               ((point->edge_lengths.array() > 0.0).all() &&
                check_admissibility(model.topology, point->edge_lengths).admissible());
    };
    if (is_feasible(1.0))
        return 1.0;
    double low = 0.0;
    double high = 1.0;
    if (!is_feasible(low))
        throw InvalidInput(
            "--feasible: the mean of the model is itself infeasible, no sample can be moved to it; "
            "without --feasible the nearest meshes are written");
    for (int round = 0; round < 20; ++round) {
        const double middle = 0.5 * (low + high);
        (is_feasible(middle) ? low : high) = middle;
    }
    return 0.99 * low;
}

/// Independent normal scores: sample i is the same whatever their number.
std::vector<ModelPoint> sampled_points(const ShapeModel& model, const Arguments& arguments,
                                       std::int64_t seed)
{
    Random random(static_cast<std::uint64_t>(seed));
    const Eigen::VectorXd deviations = standard_deviations(model);
    std::vector<ModelPoint> points;
    for (std::int64_t i = 0; i < arguments.samples; ++i) {
        Eigen::VectorXd scores(model.mode_count());
        for (Eigen::Index k = 0; k < scores.size(); ++k)
            scores[k] = deviations[k] * random.normal();
        const double share = arguments.feasible ? feasible_share(model, scores) : 1.0;
        points.push_back({numbered_name("sample", to_size(i)), share * scores,
                          size_of(model, arguments), share, scores.squaredNorm()});
    }
    return points;
}

/// @param sigmas  Those of --sigma.
std::vector<ModelPoint> wanted_points(const Session& session, const ShapeModel& model,
                                      const Arguments& arguments, const std::vector<double>& sigmas)
{
    if (arguments.mode > 0)
        return mode_points(model, arguments, sigmas);
    if (!arguments.scores.empty())
        return {point_of_scores(model, arguments)};
    if (!arguments.scores_file.empty())
        return points_of_file(model, arguments);
    if (arguments.samples > 0)
        return sampled_points(model, arguments, session.seed);
    return {{"mean", Eigen::VectorXd(), size_of(model, arguments)}};
}

/// The whole numbers around a sweep, all up to a range of 12: it passes through the meshes that are made of these points
/// alone, and between two of them it is the same whatever its ends.
std::vector<double> stations_of(double from, double to)
{
    const auto [low, high] = std::minmax(from, to);
    double spacing = 1.0;
    while ((high - low) / spacing > 12.0)
        spacing *= 2.0;
    std::vector<double> stations;
    for (double k = std::floor(low / spacing); k < std::ceil(high / spacing); ++k)
        stations.push_back(k * spacing);
    stations.push_back(std::ceil(high / spacing) * spacing);
    return stations;
}

/// The path along a mode [standard deviations], if its points are of edge-length space.
/// @param model  Outlives it.
std::optional<FramePath> sweep_of(const ShapeModel& model, const Arguments& arguments,
                                  const std::vector<double>& sigmas)
{
    const auto shape = [&model, mode = arguments.mode](double sigma) {
        return shape_of(model, scores_along(model, mode, sigma));
    };
    if (sigmas.size() < 2 || !std::holds_alternative<ShapePoint>(shape(sigmas.front())))
        return {};
    constexpr int steps_between_stations = 15;
    const std::vector<double> stations = stations_of(sigmas.front(), sigmas.back());
    return FramePath{{[shape](double sigma) { return std::get<ShapePoint>(shape(sigma)); },
                      stations, steps_between_stations * (static_cast<int>(stations.size()) - 1)},
                     sigmas};
}

/// What the meshes of all shards depend on.
Json settings_of(const Session& session, const Arguments& arguments, const ShapeModel& model,
                 const std::vector<ModelPoint>& points)
{
    Json settings = file_settings(session, arguments.embedding, arguments.output);
    const auto hash = [](const auto& array, const std::string& before) {
        return hash_text(array.data(), to_size(array.size()) * sizeof(double), before);
    };
    std::string all = hash(model.modes, hash(model.mean, ""));
    for (const ModelPoint& point : points) {
        all = hash_text(point.name.data(), point.name.size(), hash(point.scores, all));
        all = hash_text(&point.size, sizeof point.size, all);
    }
    settings["points"] = all;
    return settings;
}

/// Says how many samples --feasible has moved and how far, in a line and in the figures of each: what comes out is not
/// what was drawn.
void tell_moved(const Session& session, const std::vector<const ModelPoint*>& samples, bool verbose,
                Json& figures)
{
    std::vector<double> shares;
    double drawn = 0.0;
    double kept = 0.0;
    for (std::size_t i = 0; i < samples.size(); ++i) {
        const ModelPoint& sample = *samples[i];
        const bool is_moved = sample.share < 1.0;
        figures["embeddings"][i]["moved"] = is_moved;
        figures["embeddings"][i]["share"] = sample.share;
        drawn += sample.drawn;
        kept += sample.scores.squaredNorm();
        if (!is_moved)
            continue;
        shares.push_back(sample.share);
        if (verbose)
            session.message(join(sample.name, ": moved to ", rounded(100.0 * sample.share),
                                 " % of its scores"));
    }
    if (shares.empty())
        return session.message("--feasible: no sample had to be moved");
    const auto [least, most] = std::minmax_element(shares.begin(), shares.end());
    session.message(join("--feasible: ", shares.size(), " of ", counted(samples.size(), "sample"),
                         " had lengths that no mesh has: moved towards the mean, to ",
                         rounded(100.0 * *least), " to ", rounded(100.0 * *most),
                         " % of their scores (median ", rounded(100.0 * median(shares)),
                         " %). So they vary less than the model: the squares of all scores sum up "
                         "to ",
                         rounded(100.0 * kept / drawn), " % of what was drawn"));
}

void run(const Session& session, const Arguments& arguments)
{
    const ShapeModel model = read_model(arguments.model);
    if (arguments.size && scale_of(model.space) == Scale::None)
        throw UsageError(join("--size: ", arguments.model,
                              " was made with --scale none, size is part of its modes"));
    const std::vector<double> sigmas =
        arguments.mode > 0 ? sigma_values(arguments.sigma) : std::vector<double>();
    const std::vector<ModelPoint> points = wanted_points(session, model, arguments, sigmas);
    const bool has_size = scale_of(model.space) == Scale::Unit; // else it is a part of the shape
    std::vector<EmbeddingTarget> targets;
    std::vector<const ModelPoint*> own;
    for (const std::size_t i : arguments.shard.own(points.size())) {
        own.push_back(&points[i]);
        targets.push_back(
            {.name = points[i].name,
             .shape = [&model, &point = points[i]] { return shape_of(model, point.scores); },
             .frame = i,
             .resized = has_size ? points[i].size / model.mean_size() : 1.0});
    }
    std::vector<std::filesystem::path> inputs{arguments.model};
    if (!arguments.scores_file.empty())
        inputs.emplace_back(arguments.scores_file);
    check_merged_output(arguments.shard, arguments.output.path);
    MeshOutputArguments place = arguments.output;
    if (arguments.shard.is_given())
        place.path = arguments.shard.directory(place.path).string() + "/";
    MeshOutput output(session, place, names(targets), inputs);
    // The meshes of a shard are not neighbours, but of one path.
    const bool is_sequence = arguments.mode > 0 && !arguments.shard.is_given();
    Json figures = embed_and_write(
        session, arguments.embedding, model.topology, {model.reference_points}, targets, output,
        is_sequence ? TargetOrder::Sequence : TargetOrder::Any, sweep_of(model, arguments, sigmas));
    if (arguments.feasible)
        tell_moved(session, own, arguments.embedding.verbose, figures);
    session.print_figures(figures);
    if (arguments.shard.is_given())
        write_shard_manifest(place.path, arguments.shard, points.size(),
                             settings_of(session, arguments, model, points),
                             relative_to(place.path, output.paths()));
    merge_shards_of_ranks(session, arguments.output.path);
}

} // namespace

Run set_up_generate(CLI::App& command)
{
    command.description(
        "Make meshes from points of a model, in the space it was fitted in: its mean, points\n"
        "along a mode, given scores, or seeded samples. Points of Procrustes space are meshes\n"
        "already: the embedding options do not touch them.");
    command.footer(
        "Examples:\n"
        "  shape generate model.h5 -o mean.ply --mean\n"
        "  shape generate model.h5 -o mode1/ --mode 1 --sigma -2:2:5");
    const auto arguments = std::make_shared<Arguments>();
    command.add_option("MODEL", arguments->model, "Model made by `shape stats` (.h5)")
        ->required()
        ->option_text("REQUIRED");
    add_mesh_output(command, arguments->output);
    add_animation_options(command, arguments->output);
    CLI::Option_group* points = command.add_option_group("Points", "exactly one of");
    points->add_flag("--mean", arguments->mean, "The mean (mean.ply)");
    CLI::Option* mode = add_integer(
        *points, "--mode", arguments->mode,
        "Points along mode K, [1, number of modes]; needs --sigma. Names: mode01_-2.00.ply.\n"
        "Neighbours of 31 or more agree on every fold (method dihedral, quality fine)",
        1, std::numeric_limits<int>::max());
    points
        ->add_option("--scores", arguments->scores,
                     "One point, scores of the first modes in standard deviations, any sign;\n"
                     "the others are 0 (scores.ply)")
        ->option_text("s1,s2,...");
    points
        ->add_option("--scores-file", arguments->scores_file,
                     "One mesh a row of a CSV file as `shape project` writes it: `mesh` is the\n"
                     "name, pc1, pc2, ... are coordinates along the modes (not standard\n"
                     "deviations), `size` is used if it is there and --size is not given")
        ->option_text("FILE");
    add_integer(*points, "--sample", arguments->samples,
                "N independent samples with normal scores (see --seed), [1, 1000000]\n"
                "(sample_0000.ply, ...)",
                1, most_meshes);
    points->require_option(1);
    command
        .add_flag("--feasible", arguments->feasible,
                  "With --sample: samples whose lengths no mesh has are moved towards the mean\n"
                  "until one may have them; the others stay. Says how many and how far: they vary\n"
                  "less than the model (docs/statistics.md)")
        ->needs(points->get_option("--sample"));
    CLI::Option* sigma =
        command
            .add_option("--sigma", arguments->sigma,
                        "N equally spaced values from A to B in standard deviations, both ends\n"
                        "included, N in [2, 1000000]; or one value")
            ->option_text("A:B:N");
    mode->needs(sigma);
    sigma->needs(mode);
    add_number(command, "--size", arguments->size,
               "Sum of the edge lengths of the model's mean, in Procrustes space the centroid\n"
               "size [unit of the input], > 0 (default: the mean size of the model's meshes)",
               Sign::Positive);
    add_shard(command, arguments->shard);
    add_embedding_options(command, arguments->embedding);
    return [arguments](const Session& session) { run(session, *arguments); };
}

} // namespace shape::tools
