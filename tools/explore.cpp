// SPDX-License-Identifier: MIT

#include <CLI/CLI.hpp>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>

#include "libshape/base/counted.h"
#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/to_size.h"
#include "libshape/base/version.h"
#include "libshape/explore/block_of_model.h"
#include "libshape/explore/model_block.h"
#include "libshape/io/file/output_file.h"
#include "libshape/io/label_doubts.h"
#include "libshape/io/model_file.h"
#include "libshape/io/table_file.h"
#include "libshape/io/vertex_scalars.h"
#include "libshape/mesh/oddities.h"
#include "libshape/model/unlike_meshes.h"
#include "libshape/report/base64.h"
#include "libshape/report/page.h"
#include "libshape/report/picture.h"
#include "libshape/report/score_plot.h"
#include "libshape/statistics/regression.h"
#include "tools/commands.h"
#include "tools/explore/page_frame.h"
#include "tools/input/label_input.h"
#include "tools/input/space_arguments.h"
#include "tools/output/embedding_run.h"
#include "tools/output/model_tables.h"
#include "tools/output/output_rules.h"
#include "tools/output/unlike_warnings.h"
#include "tools/program/arguments.h"
#include "tools/program/session.h"

namespace shape::tools {
using namespace internal;
namespace {

constexpr int pictured_modes = 3;    ///< Where no mesh can be drawn.
constexpr double plot_width = 490.0; ///< [px]; two side by side fill the page.
constexpr double plot_height = 400.0;

struct Arguments
{
    std::string model;
    std::string output;
    std::string title;
    std::string about;
    std::string color_by;
    std::string effects;
    std::vector<std::string> differences;
    std::vector<std::string> regressions;
    std::int64_t modes = 200;
    double smoothness = default_smoothness;
};

/// With two decimals.
std::string print_fixed(double value)
{
    char text[32];
    std::snprintf(text, sizeof text, "%.2f", value);
    return text;
}

/// With as many digits as single precision has.
Json numbers(const Eigen::VectorXd& values)
{
    Json list = Json::array();
    for (const double value : values) {
        char text[32];
        std::snprintf(text, sizeof text, "%.9g", value);
        list.push_back(std::strtod(text, nullptr));
    }
    return list;
}

/// What is added to points of the model, with a slider each.
struct Additions
{
    AddedDirections directions;
    Json differences = Json::array();
    Json regressions = Json::array();
};

std::string stem(const std::string& path)
{
    return std::filesystem::path(path).stem().string();
}

/// What is unlike the model in the meshes of a difference; sizes that it divides out may be any.
Eigen::RowVector2d marks_of(const ShapeModel& model, const DifferenceVector& difference,
                            const std::string& file)
{
    const Collection meshes{difference.topology, {file}, {difference.reference_points}, {}};
    Eigen::RowVector2d marks = unlike_meshes(known_meshes(model), meshes,
                                             Eigen::VectorXd::Constant(1, difference.from_size))
                                   .row(0);
    if (difference.scale == Scale::Unit)
        marks[1] = 0.0;
    return marks;
}

/// Differences from their files, in units of length at the mean size.
void add_differences(const Session& session, const Arguments& arguments, const ShapeModel& model,
                     Additions& to)
{
    const auto count = static_cast<Eigen::Index>(arguments.differences.size());
    RowMatrix marks = RowMatrix::Zero(count, 2);
    to.directions = {RowMatrix(count, model.topology.edge_count()),
                     RowMatrix(count, model.topology.edge_count())};
    for (Eigen::Index i = 0; i < count; ++i) {
        const std::string& file = arguments.differences[to_size(i)];
        const DifferenceVector difference = read_difference(file);
        if (!std::holds_alternative<EdgeSpace>(model.space))
            throw InvalidInput(join("--difference: ", arguments.model,
                                    " is a model of Procrustes space; differences are added in "
                                    "edge space"));
        if (!(difference.topology == model.topology))
            throw InvalidInput(join(
                "--difference: ", file, " has another triangulation than ", arguments.model, "; ",
                describe_correspondence_break(
                    {arguments.model, arguments.model, model.reference_points,
                     model.topology.faces()},
                    {file, file, difference.reference_points, difference.topology.faces()})));
        marks.row(i) = marks_of(model, difference, file);
        const double size = difference.scale == Scale::Unit ? model.mean_size() : 1.0;
        to.directions.edge_lengths.row(i) = size * difference.edge_lengths.transpose();
        to.directions.dihedral_angles.row(i) = difference.dihedral_angles.transpose();
        to.differences.push_back(
            {{"name", stem(file)},
             {"meaning", difference.pairs.empty() ? std::string("of two groups")
                                                  : counted(difference.pairs.size(), "pair")}});
    }
    warn_of_unlike(session, arguments.differences, marks,
                   {.option = "--difference: ",
                    .others = join("the meshes of ", arguments.model),
                    .mirrored = "angles change the wrong way",
                    .size = "Lengths are added as they are (--scale none): bring all to one unit "
                            "first",
                    .are_differences = true});
}

/// The meshes that have a value of a label; of the others a note.
std::vector<std::size_t> with_value(const Session& session, const ShapeModel& model,
                                    const LabelColumn& label)
{
    std::vector<std::size_t> with;
    std::vector<std::size_t> without;
    for (std::size_t i = 0; i < label.values.size(); ++i)
        (label.values[i].empty() ? without : with).push_back(i);
    constexpr std::size_t least = 3; // of a line and something that is left
    if (with.size() < least)
        throw InvalidInput(join("--regress ", label.name, ": ",
                                counted(with.size(), "mesh has", "meshes have"),
                                " a value of it, at least ", least, " are needed"));
    if (!without.empty())
        session.message(join("--regress ", label.name, ": ", list_names(model.names, without),
                             without.size() == 1 ? " has" : " have",
                             " no value of it; scores are regressed on those of the other ",
                             with.size(), " meshes"));
    return with;
}

/// Regressions of the scores on labels of the model's meshes.
void add_regressions(const Session& session, const Arguments& arguments, const ShapeModel& model,
                     Additions& to)
{
    for (const std::string& name : arguments.regressions) {
        const LabelColumn& label = find_label(model.labels, name);
        if (const auto doubt = doubt_about_numbers(label))
            session.warn(*doubt);
        const std::vector<std::size_t> meshes = with_value(session, model, label);
        Eigen::MatrixXd values(static_cast<Eigen::Index>(meshes.size()), 1);
        for (std::size_t i = 0; i < meshes.size(); ++i)
            values(static_cast<Eigen::Index>(i), 0) =
                number_of_label(label, meshes[i], model.names, join("--regress: ", arguments.model),
                                "; correct it, or leave the cell empty, and make the model again");
        if (values.minCoeff() == values.maxCoeff())
            throw InvalidInput(
                join("--regress ", name, ": is constant, ", values(0, 0), " for all ",
                     counted(values.rows(), "mesh", "meshes"),
                     "; scores are regressed on numbers that differ between meshes"));
        const RowMatrix scores = model.scores(meshes, Eigen::all);
        const Regression regression = regress(scores, values);
        // Of all meshes scores have the mean 0, but for rounding.
        const Eigen::RowVectorXd offset = meshes.size() == model.names.size()
                                              ? Eigen::RowVectorXd::Zero(scores.cols()).eval()
                                              : scores.colwise().mean().eval();
        to.regressions.push_back({{"name", name},
                                  {"low", values.minCoeff()},
                                  {"high", values.maxCoeff()},
                                  {"mean", regression.covariate_means[0]},
                                  {"slope", numbers(regression.slopes.row(0))},
                                  {"offset", numbers(offset)},
                                  {"meshes", meshes.size()}});
    }
}

/// The mean and both ends of the leading modes, for browsers that draw no meshes.
std::string draw_modes(const Session& session, const ShapeModel& model)
{
    constexpr double reach = 2.0; // [standard deviations]
    const Progress progress = session.progress();
    const Embedder embedder(model.topology, {model.reference_points},
                            {.quality = EmbeddingQuality::Preview});
    Collection shown{.topology = model.topology, .names = {}, .points = {}, .labels = {}};
    const int modes = std::min(pictured_modes, model.mode_count());
    for (int mode = 0; mode < modes; ++mode) {
        progress("embedding", to_size(mode), to_size(modes));
        const FeasibleRange range = feasible_range(model, mode, reach);
        for (const double sigma : {range.low, 0.0, range.high}) {
            Eigen::VectorXd scores = Eigen::VectorXd::Zero(mode + 1);
            scores[mode] = sigma * std::sqrt(model.variances[mode]);
            const std::string name = join("mode ", mode + 1, " at ", print_fixed(sigma));
            shown.points.push_back(
                embedder.embed(model_point(model, scores, model.mean_size())).points);
            shown.names.push_back(name);
        }
    }
    progress("embedding", 1, 1);
    PictureOptions options;
    options.columns = 3;
    options.cell_width = 150;
    options.scale = 1;
    return picture_svg(draw_collection(shown, options));
}

std::vector<std::pair<std::string, std::string>> facts_of(const Arguments& arguments,
                                                          const ShapeModel& model)
{
    const Json space = space_figures(model.space);
    std::vector<std::pair<std::string, std::string>> facts{
        {"Model", arguments.model},
        {"Meshes", join(model.names.size())},
        {"Vertices", join(model.topology.vertex_count())},
        {"Faces", join(model.topology.face_count())},
        {"Space",
         join(space["space"].get<std::string>(), ", scale ", space["scale"].get<std::string>())},
        {"Mean size", join(model.mean_size())},
        {"Modes", join(model.mode_count())},
        {"Embedding", join("dihedral, smoothness ", arguments.smoothness)},
        {"Made by", join("shape ", version())}};
    if (!arguments.about.empty())
        facts.insert(facts.begin(), {"About", arguments.about});
    return facts;
}

/// One end of a feasible range; where nothing broke as far as was looked, that.
std::string print_feasible(double end)
{
    return std::abs(end) < feasible_reach ? print_fixed(end)
                                          : join(end < 0 ? "below -" : "above ", feasible_reach);
}

/// @param modes  How many, the first ones.
std::vector<std::vector<std::string>> table_of(const ShapeModel& model, int modes)
{
    std::vector<std::vector<std::string>> table{
        {"Mode", "Variance", "Share [%]", "Cumulative [%]", "Feasible from", "to [std. dev.]"}};
    for (const Json& mode : mode_figures(model)) {
        if (static_cast<int>(table.size()) > modes)
            break;
        const auto number = [&](const char* field) { return mode[field].get<double>(); };
        table.push_back(
            {join(mode["mode"].get<int>()), join(number("variance")),
             print_fixed(100.0 * number("share")), print_fixed(100.0 * number("cumulative")),
             print_feasible(number("feasible_low")), print_feasible(number("feasible_high"))});
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

/// What the page's program knows of the model; docs/formats.md tells the fields.
Json model_json(const Arguments& arguments, const ShapeModel& model, int modes,
                const std::string& title, const Additions& additions)
{
    Json json{{"title", title},
              {"file", arguments.model},
              {"version", version()},
              {"space", std::holds_alternative<EdgeSpace>(model.space) ? "edge" : "procrustes"},
              {"size", model.mean_size()},
              {"smoothness", arguments.smoothness},
              {"colorBy", arguments.color_by},
              {"modes", Json::array()},
              {"specimens", Json::array()},
              {"labels", Json::array()},
              {"differences", additions.differences},
              {"regressions", additions.regressions},
              {"effects", nullptr}};
    const Eigen::Matrix3d view = automatic_view(model.topology.faces(), model.reference_points);
    json["view"] = numbers(view.reshaped<Eigen::RowMajor>());
    for (int k = 0; k < modes; ++k) {
        const FeasibleRange range = feasible_range(model, k, feasible_reach);
        json["modes"].push_back({{"share", model.variances[k] / model.total_variance},
                                 {"deviation", std::sqrt(model.variances[k])},
                                 {"low", range.low},
                                 {"high", range.high}});
    }
    for (std::size_t i = 0; i < model.names.size(); ++i) {
        const auto row = static_cast<Eigen::Index>(i);
        json["specimens"].push_back({{"name", model.names[i]},
                                     {"size", model.sizes[row]},
                                     {"scores", numbers(model.scores.row(row).head(modes))}});
    }
    for (const LabelColumn& label : model.labels)
        json["labels"].push_back({{"name", label.name}, {"values", label.values}});
    if (!arguments.effects.empty()) {
        const Eigen::VectorXf values =
            read_vertex_scalar(arguments.effects, "effect").cast<float>();
        if (values.size() != model.topology.vertex_count())
            throw InvalidInput(join("--effects: ", arguments.effects, " has ", values.size(),
                                    " vertices, ", arguments.model, " ",
                                    model.topology.vertex_count()));
        json["effects"] = {{"name", join("effects (", stem(arguments.effects), ")")},
                           {"values", base64({reinterpret_cast<const char*>(values.data()),
                                              sizeof(float) * to_size(values.size())})}};
    }
    return json;
}

void run(const Session& session, const Arguments& arguments)
{
    if (!has_ending(arguments.output, ".htm")) // as some systems have it
        check_ending("-o", arguments.output, ".html");
    std::vector<std::filesystem::path> inputs{arguments.model};
    inputs.insert(inputs.end(), arguments.differences.begin(), arguments.differences.end());
    if (!arguments.effects.empty())
        inputs.emplace_back(arguments.effects);
    check_output(session, arguments.output, inputs);
    const ShapeModel model = read_model(arguments.model);
    const std::vector<std::string> values =
        arguments.color_by.empty() ? std::vector<std::string>()
                                   : find_label(model.labels, arguments.color_by).values;
    const std::string_view frame = page_frame();
    if (frame.empty())
        throw UsageError(
            "libshape was built without the page; `tools/install_packages build explore` and "
            "`tools/install_node_packages explore` get what it needs, then build anew");
    Additions additions;
    add_differences(session, arguments, model, additions);
    add_regressions(session, arguments, model, additions);
    const int modes = static_cast<int>(std::min<std::int64_t>(arguments.modes, model.mode_count()));
    const std::string title = arguments.title.empty()
                                  ? join("Shape model of ", model.names.size(), " meshes")
                                  : arguments.title;
    const Json json = model_json(arguments, model, modes, title, additions);
    Page page{.title = title,
              .facts = facts_of(arguments, model),
              .pictures = draw_modes(session, model),
              .drawings = {},
              .table = table_of(model, modes),
              .model = json.dump(-1, ' ', false, Json::error_handler_t::replace),
              .block = write_block(make_block(model, modes, std::move(additions.directions),
                                              arguments.smoothness, session.progress()))};
    if (model.mode_count() > 1)
        page.drawings.push_back(draw_scores(model, values));
    page.drawings.push_back(draw_variance(model));
    const std::string html = page_html(page, frame);
    write_file_atomically(arguments.output, html);
    session.message(join(arguments.output, ": ", modes, " of ", counted(model.mode_count(), "mode"),
                         " of ", model.names.size(), " meshes; open it in a browser"));
    session.print_figures({{"outputs", {arguments.output}},
                           {"modes", modes},
                           {"bytes", html.size()},
                           {"block_bytes", page.block.size()}});
}

} // namespace

Run set_up_explore(CLI::App& command)
{
    command.description(
        "Put a model into one page for any browser, which needs no other file, no server and no\n"
        "network: meshes are made in it, from any scores, with their errors; sliders, the plot of\n"
        "the scores, group means, exports, and the figures of the model. `explore` and `report`\n"
        "make the same page.");
    command.footer(
        "Examples:\n  shape explore model.h5 -o faces.html --color-by expression\n"
        "  shape explore model.h5 -o faces.html --difference smile.h5 --regress age");
    const auto arguments = std::make_shared<Arguments>();
    command.add_option("MODEL", arguments->model, "Model made by `shape stats` (.h5)")
        ->required()
        ->option_text("REQUIRED");
    add_output_file(command, arguments->output, "Page to write (.html)");
    command
        .add_option("--title", arguments->title,
                    "Title of the page (default: the number of meshes)")
        ->option_text("TEXT");
    command
        .add_option("--about", arguments->about,
                    "Where the meshes come from, whose they are: shown with the figures")
        ->option_text("TEXT");
    add_label(command, "--color-by", arguments->color_by,
              "Label whose values get a colour each in the plot of the scores, and whose means\n"
              "get buttons, when the page is opened");
    command
        .add_option("--difference", arguments->differences,
                    "Difference of `shape difference` (.h5) that gets a slider; repeatable")
        ->option_text("FILE")
        ->allow_extra_args(false);
    command
        .add_option("--regress", arguments->regressions,
                    "Label with numbers, such as age, on which scores are regressed: a slider in\n"
                    "its unit; repeatable")
        ->option_text("LABEL")
        ->allow_extra_args(false);
    command
        .add_option("--effects", arguments->effects,
                    "Mesh of --effects (.ply) by whose effects the mesh can be coloured")
        ->option_text("FILE");
    add_integer(command, "--modes", arguments->modes,
                "Modes in the page, [1, 1000] (default: 200, or as many as there are)", 1, 1000);
    add_number(command, "--smoothness", arguments->smoothness,
               "Weight of the dihedral angles, as of `shape generate`, > 0 (default: 0.005)",
               Sign::Positive);
    return [arguments](const Session& session) { run(session, *arguments); };
}

} // namespace shape::tools
