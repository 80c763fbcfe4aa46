// SPDX-License-Identifier: MIT

#include <CLI/CLI.hpp>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>

#include "libshape/base/counted.h"
#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/stop.h"
#include "libshape/base/to_size.h"
#include "libshape/io/file/output_file.h"
#include "libshape/io/table_file.h"
#include "libshape/model/model_quality.h"
#include "libshape/report/plot.h"
#include "tools/commands.h"
#include "tools/input/label_input.h"
#include "tools/input/mesh_stream_input.h"
#include "tools/input/repeated_rows.h"
#include "tools/input/space_arguments.h"
#include "tools/output/embedding_run.h"
#include "tools/output/output_rules.h"
#include "tools/output/pass_store.h"
#include "tools/output/plot_output.h"
#include "tools/program/arguments.h"
#include "tools/program/ranks.h"
#include "tools/program/session.h"

namespace shape::tools {
using namespace internal;
namespace {

constexpr Eigen::Index most_left_out_one_by_one = 50;
constexpr int usual_folds = 10;

struct Arguments
{
    LabelledInput input;
    std::string output;
    std::string plot;
    std::string modes;
    std::int64_t folds = 0;
    std::string leave_out;
    std::int64_t tests = 25;
    std::int64_t samples = 25;
    SpaceOptions space = {};
    EmbeddingOptions embedding = {};
    MemoryArgument memory;
};

/// The numbers of "1,2,5".
std::vector<int> mode_counts(const std::string& text)
{
    std::vector<int> counts;
    for (const double count : read_numbers(text, "--modes")) {
        if (count != std::floor(count) || count < 1.0 || count > 1e6 ||
            (!counts.empty() && count <= counts.back()))
            throw UsageError(
                join("--modes: '", text, "' must be integers in [1, 1000000] that ascend"));
        counts.push_back(static_cast<int>(count));
    }
    return counts;
}

Grouping folds_of(const Session& session, const Arguments& arguments, const MeshLabels& labels)
{
    if (!arguments.leave_out.empty())
        return group_by_label(labels, arguments.leave_out);
    const auto meshes = static_cast<Eigen::Index>(labels.names.size());
    if (meshes < 3)
        throw InvalidInput(join("the quality of a model needs at least 3 meshes, not ", meshes,
                                ": two that make it when one is left out"));
    warn_of_repeated_rows(session, labels,
                          {.covariates = Eigen::MatrixXd(meshes, 0),
                           .remedy = "then the model looks better than it is. Give --leave-out"});
    const int usual = meshes <= most_left_out_one_by_one ? static_cast<int>(meshes) : usual_folds;
    return random_folds(meshes, arguments.folds > 0 ? static_cast<int>(arguments.folds) : usual,
                        static_cast<std::uint64_t>(session.seed));
}

struct NamedCurve
{
    std::string name;
    const QualityCurve* curve;
};

std::vector<NamedCurve> curves(const ModelQuality& quality)
{
    return {{"generalisation_vertex", &quality.generalisation_vertex},
            {"generalisation_edge", &quality.generalisation_edge},
            {"specificity_vertex", &quality.specificity_vertex},
            {"specificity_edge", &quality.specificity_edge}};
}

Table quality_table(const ModelQuality& quality)
{
    Table table{{"modes", "compactness"}, {}};
    for (std::size_t k = 0; k < quality.modes.size(); ++k)
        table.rows.push_back({std::to_string(quality.modes[k]),
                              print_number(quality.compactness[static_cast<Eigen::Index>(k)])});
    for (const auto& [name, curve] : curves(quality)) {
        table.columns.push_back(name);
        table.columns.push_back(name + "_sd");
        for (std::size_t k = 0; k < quality.modes.size(); ++k) {
            table.rows[k].push_back(print_number(curve->mean[static_cast<Eigen::Index>(k)]));
            table.rows[k].push_back(print_number(curve->deviation[static_cast<Eigen::Index>(k)]));
        }
    }
    return table;
}

/// Three plots side by side: variance, distances of vertices, differences of lengths; these with the
/// standard deviations over the meshes.
std::string draw(const ModelQuality& quality)
{
    const auto series = [&](const char* name, const Eigen::VectorXd& values,
                            const Eigen::VectorXd& deviations = {}) {
        Series result{.name = name,
                      .points = Eigen::MatrixX2d(values.size(), 2),
                      .tips = {},
                      .curve = true,
                      .deviations = deviations};
        for (Eigen::Index k = 0; k < values.size(); ++k)
            result.points.row(k) << quality.modes[to_size(k)], values[k];
        return result;
    };
    const auto curve = [&](const char* name, const QualityCurve& measure) {
        return series(name, measure.mean, measure.deviation);
    };
    const auto plot = [&](const char* title, const char* unit, std::vector<Series> all) {
        // A curve starts at 0 of its axis to show how far it falls.
        all.push_back(
            {.name = {}, .points = Eigen::MatrixX2d::Zero(1, 2), .tips = {}, .curve = true});
        return Plot{.title = title,
                    .x_label = "modes",
                    .y_label = unit,
                    .series = std::move(all),
                    .equal_axes = false};
    };
    constexpr double width = 360.0;
    constexpr double height = 320.0;
    Svg svg(3.0 * width, height);
    svg.rectangle(0.0, 0.0, 3.0 * width, height, {255, 255, 255});
    draw_plot(svg, {0.0, 0.0, width, height},
              plot("Compactness", "share of variance", {series("", quality.compactness)}));
    draw_plot(svg, {width, 0.0, width, height},
              plot("Aligned vertices", "RMS distance [unit of the input]",
                   {curve("generalisation", quality.generalisation_vertex),
                    curve("specificity", quality.specificity_vertex)}));
    draw_plot(svg, {2.0 * width, 0.0, width, height},
              plot("Edge lengths", "RMS difference / mean length",
                   {curve("generalisation", quality.generalisation_edge),
                    curve("specificity", quality.specificity_edge)}));
    return svg.document();
}

std::string text_of(const ModelQuality& quality)
{
    std::string text =
        "modes  compactness  generalisation (vertex, edge)  specificity (vertex, edge)\n";
    for (std::size_t k = 0; k < quality.modes.size(); ++k) {
        const auto row = static_cast<Eigen::Index>(k);
        char line[160];
        std::snprintf(
            line, sizeof line, "%5d  %10.2f%%  %15.5g  %10.3f%%  %14.5g  %10.3f%%\n",
            quality.modes[k], 100.0 * quality.compactness[row],
            quality.generalisation_vertex.mean[row], 100.0 * quality.generalisation_edge.mean[row],
            quality.specificity_vertex.mean[row], 100.0 * quality.specificity_edge.mean[row]);
        text += line;
    }
    return text;
}

void check_outputs(const Session& session, const Arguments& arguments)
{
    check_space_options(arguments.space);
    const std::vector<std::filesystem::path> inputs = input_files(arguments.input.meshes);
    check_ending("-o", arguments.output, ".csv");
    check_output(session, arguments.output, inputs);
    if (arguments.plot.empty())
        return;
    check_picture("--plot", arguments.plot);
    check_output(session, arguments.plot, inputs);
}

void run(const Session& session, const Arguments& arguments)
{
    const std::vector<int> modes =
        arguments.modes.empty() ? std::vector<int>() : mode_counts(arguments.modes);
    check_outputs(session, arguments);
    const auto meshes = open_for_passes(session, arguments.input, arguments.space, arguments.memory,
                                        ranks().partial_sums > 1);
    const Collection collection =
        meshes ? Collection{meshes->topology, meshes->names, {}, meshes->labels}
               : read_labelled(session, arguments.input);
    const Grouping folds = folds_of(session, arguments, collection);
    const QualityOptions options{.space = arguments.space,
                                 .modes = modes,
                                 .tests = static_cast<int>(arguments.tests),
                                 .samples = static_cast<int>(arguments.samples),
                                 .embedding = embedding_options(session, arguments.embedding),
                                 .seed = static_cast<std::uint64_t>(session.seed)};
    StreamOptions stream;
    stream.memory = arguments.memory.bytes;
    stream.scratch = scratch_folder(arguments.output);
    stream.ranks = ranks();
    const ModelQuality quality =
        meshes ? measure_quality(*meshes, folds, options, stream, session.progress())
               : measure_quality(collection, folds, options, session.progress());
    throw_if_stop_requested();
    if (!ranks().is_root())
        return;
    const std::string drawing = arguments.plot.empty() ? std::string() : draw(quality);
    std::vector<std::string> outputs{arguments.output};
    write_table(arguments.output, quality_table(quality));
    if (!drawing.empty()) {
        write_picture(arguments.plot, drawing);
        outputs.push_back(arguments.plot);
    }
    session.message(text_of(quality));
    session.message(join(counted(quality.tests, "mesh", "meshes"), " left out in ",
                         counted(folds.group_count(), "fold"), ", ",
                         counted(arguments.samples, "sample"), "; ", quality.infeasible, " of ",
                         quality.decoded,
                         " decoded meshes are nearest ones of infeasible lengths"));
    Json figures{{"outputs", outputs},
                 {"meshes", collection.names.size()},
                 {"folds", folds.group_count()},
                 {"tests", quality.tests},
                 {"samples", arguments.samples},
                 {"decoded", quality.decoded},
                 {"infeasible", quality.infeasible},
                 {"modes", quality.modes},
                 {"compactness", quality.compactness}};
    for (const auto& [name, curve] : curves(quality)) {
        figures[name] = curve->mean;
        figures[name + "_sd"] = curve->deviation;
    }
    session.print_figures(figures);
}

} // namespace

Run set_up_quality(CLI::App& command)
{
    command.description(
        "Measure how good models of the meshes are with growing numbers of modes, on decoded\n"
        "meshes. Compactness: the share of the variance. Generalisation: the distance of meshes\n"
        "that were left out to their reconstructions by a model of the others. Specificity: the\n"
        "distance of random meshes of the model to the nearest mesh. Distances are RMS distances\n"
        "of vertices after rigid alignment [unit of the input] and RMS differences of edge\n"
        "lengths over the mean length; for unit scale both meshes are brought to one size before.");
    command.footer(
        "Example:\n"
        "  shape quality faces.h5 -o quality.csv --plot quality.svg --leave-out subject");
    const auto arguments = std::make_shared<Arguments>();
    add_labelled_input(command, arguments->input);
    add_output_file(command, arguments->output,
                    "CSV file to write: modes, compactness, then mean and standard deviation of\n"
                    "generalisation and specificity in vertices and edges");
    command
        .add_option("--plot", arguments->plot,
                    "Draw the curves, with standard deviations over the meshes (.svg or .png)")
        ->option_text("FILE");
    command
        .add_option("--modes", arguments->modes,
                    "Numbers of modes to measure at, ascending (default: 1,2,5,10,20,50 as far as\n"
                    "the models have them)")
        ->option_text("k1,k2,...");
    CLI::Option* folds = add_integer(
        command, "--folds", arguments->folds,
        join("Leave out the meshes in this many random folds, [2, N] (default: one by one up to\n",
             most_left_out_one_by_one, " meshes, ", usual_folds, " folds of more)"),
        2, std::numeric_limits<int>::max());
    add_label(command, "--leave-out", arguments->leave_out,
              "Leave out all meshes with one value of this label together (of one person)")
        ->excludes(folds);
    add_integer(command, "--tests", arguments->tests,
                "Reconstruct at most this many of the meshes, drawn at random, >= 1 (default: 25)",
                1, std::numeric_limits<int>::max());
    add_integer(command, "--samples", arguments->samples, "Random meshes, >= 1 (default: 25)", 1,
                1'000'000);
    add_space_options(command, arguments->space);
    add_memory(command, arguments->memory);
    add_embedder_options(command, arguments->embedding);
    return [arguments](const Session& session) { run(session, *arguments); };
}

} // namespace shape::tools
