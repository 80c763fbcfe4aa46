// SPDX-License-Identifier: MIT

#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>

#include "libshape/base/counted.h"
#include "libshape/base/format.h"
#include "libshape/io/file/output_file.h"
#include "libshape/io/model_file.h"
#include "libshape/mesh/alignment.h"
#include "libshape/report/page.h"
#include "libshape/report/plot.h"
#include "tools/commands.h"
#include "tools/input/label_input.h"
#include "tools/input/space_arguments.h"
#include "tools/output/embedding_run.h"
#include "tools/output/model_tables.h"
#include "tools/output/output_rules.h"
#include "tools/program/arguments.h"
#include "tools/program/session.h"

namespace shape::tools {
using namespace internal;
namespace {

constexpr Eigen::Index most_rows = 50; ///< Of the table of modes.
constexpr double plot_width = 490.0;   ///< [px]; two side by side fill the page.
constexpr double plot_height = 400.0;

struct Arguments
{
    std::string model;
    std::string output;
    std::string color_by;
    std::int64_t modes = 3;
    double sigma = 2.0;
    std::int64_t steps = 5;
    EmbeddingOptions embedding;
};

/// The modes as what the viewer moves along, and the figures of their meshes.
struct Tracks
{
    std::vector<ShapeTrack> tracks;
    Json embeddings = Json::array();
};

Tracks decode_modes(const Session& session, const Arguments& arguments, const ShapeModel& model)
{
    const Progress progress = session.progress();
    const EmbeddingOptions options = embedding_options(session, {.options = arguments.embedding});
    const Embedder embedder(model.topology, {model.reference_points}, options);
    const auto modes = std::min<std::int64_t>(arguments.modes, model.mode_count());
    const auto steps = static_cast<std::size_t>(arguments.steps);
    Tracks result;
    for (std::int64_t mode = 0; mode < modes; ++mode) {
        ShapeTrack track{join("mode ", mode + 1), {}, -arguments.sigma, arguments.sigma};
        Eigen::VectorXd scores = Eigen::VectorXd::Zero(mode + 1);
        for (std::size_t i = 0; i < steps; ++i) {
            progress("embedding", static_cast<std::size_t>(mode) * steps + i,
                     static_cast<std::size_t>(modes) * steps);
            const double sigma =
                arguments.sigma *
                (2.0 * static_cast<double>(i) / static_cast<double>(steps - 1) - 1.0);
            scores[mode] = sigma * std::sqrt(model.variances[mode]);
            const std::string name = join(track.name, " at ", sigma);
            FinishedMesh mesh = finished_mesh(embedder, options, name,
                                              model_point(model, scores, model.mean_size()));
            warn_if_infeasible(session, name, mesh);
            const Points& onto = i == 0 ? model.reference_points : track.shapes.back();
            track.shapes.push_back(best_rigid_motion(mesh.points, onto)(mesh.points));
            result.embeddings.push_back(std::move(mesh.figures));
        }
        result.tracks.push_back(std::move(track));
    }
    progress("embedding", 1, 1);
    return result;
}

/// With two decimals.
std::string print_fixed(double value)
{
    char text[32];
    std::snprintf(text, sizeof text, "%.2f", value);
    return text;
}

std::vector<std::pair<std::string, std::string>> facts_of(const Arguments& arguments,
                                                          const ShapeModel& model)
{
    const Json space = space_figures(model.space);
    return {{"Model", arguments.model},
            {"Meshes", join(model.names.size())},
            {"Vertices", join(model.topology.vertex_count())},
            {"Faces", join(model.topology.face_count())},
            {"Space", join(space["space"].get<std::string>(), ", scale ",
                           space["scale"].get<std::string>())},
            {"Mean size", join(model.mean_size())},
            {"Modes", join(model.mode_count())}};
}

std::vector<std::vector<std::string>> table_of(const ShapeModel& model)
{
    std::vector<std::vector<std::string>> table{
        {"Mode", "Variance", "Share [%]", "Cumulative [%]", "Feasible from", "to [std. dev.]"}};
    for (const Json& mode : mode_figures(model)) {
        if (static_cast<Eigen::Index>(table.size()) > most_rows)
            break;
        const auto number = [&](const char* field) { return mode[field].get<double>(); };
        table.push_back(
            {join(mode["mode"].get<int>()), join(number("variance")),
             print_fixed(100.0 * number("share")), print_fixed(100.0 * number("cumulative")),
             print_fixed(number("feasible_low")), print_fixed(number("feasible_high"))});
    }
    return table;
}

/// The cumulative share of the variance over the number of modes.
std::string draw_variance(const ShapeModel& model)
{
    Eigen::MatrixX2d curve(model.mode_count() + 1, 2);
    curve.row(0).setZero();
    for (int k = 0; k < model.mode_count(); ++k)
        curve.row(k + 1) << k + 1.0, curve(k, 1) + model.variances[k] / model.total_variance;
    return plot_svg({.title = "Share of the variance",
                     .x_label = "modes",
                     .y_label = "cumulative share",
                     .series = {{"", curve, {}, true}},
                     .equal_axes = false},
                    plot_width, plot_height);
}

std::string draw_scores(const ShapeModel& model, const std::vector<std::string>& values)
{
    Plot plot =
        score_plot(model.scores, model.names, values, model.variances / model.total_variance);
    plot.title = "Scores";
    return plot_svg(plot, plot_width, plot_height);
}

void run(const Session& session, const Arguments& arguments)
{
    check_ending("-o", arguments.output, ".html");
    check_output(session, arguments.output, {arguments.model});
    const ShapeModel model = read_model(arguments.model);
    const std::vector<std::string> values =
        arguments.color_by.empty() ? std::vector<std::string>()
                                   : find_label(model.labels, arguments.color_by).values;
    Page page{.title = join("Shape model of ", model.names.size(), " meshes"),
              .facts = facts_of(arguments, model),
              .faces = model.topology.faces(),
              .tracks = {},
              .unit = "standard deviations",
              .drawings = {},
              .table = table_of(model)};
    if (model.mode_count() > 1)
        page.drawings.push_back(draw_scores(model, values));
    page.drawings.push_back(draw_variance(model));
    Tracks tracks = decode_modes(session, arguments, model);
    page.tracks = std::move(tracks.tracks);
    write_file_atomically(arguments.output, page_html(page));
    session.message(join(arguments.output, ": ", page.tracks.size(), " of ",
                         counted(model.mode_count(), "mode"), " of ", model.names.size(),
                         " meshes"));
    session.print_figures({{"outputs", {arguments.output}},
                           {"modes", page.tracks.size()},
                           {"embeddings", std::move(tracks.embeddings)}});
}

} // namespace

Run set_up_report(CLI::App& command)
{
    command.description(
        "Put a model on one page for any browser, which needs no other file and no network: a\n"
        "viewer that moves the mesh along the leading modes, the scores, the variances and how\n"
        "far one can go along each mode.");
    command.footer("Example:\n  shape report model.h5 -o report.html --color-by expression");
    const auto arguments = std::make_shared<Arguments>();
    command.add_option("MODEL", arguments->model, "Model made by `shape stats` (.h5)")
        ->required()
        ->option_text("REQUIRED");
    add_output_file(command, arguments->output, "Page to write (.html)");
    add_label(command, "--color-by", arguments->color_by,
              "Label whose values get a colour each in the plot of the scores");
    add_integer(command, "--modes", arguments->modes,
                "Modes in the viewer, [1, 100] (default: 3, or as many as there are)", 1, 100);
    add_number(command, "--sigma", arguments->sigma,
               "How far to go to either side [standard deviations], > 0 (default: 2)",
               Sign::Positive);
    add_integer(command, "--steps", arguments->steps,
                "Meshes made along a mode, between which the viewer blends, [2, 101] (default: 5)",
                2, 101);
    add_embedder_options(command, arguments->embedding);
    return [arguments](const Session& session) { run(session, *arguments); };
}

} // namespace shape::tools
