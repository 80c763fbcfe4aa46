// SPDX-License-Identifier: MIT

#include <CLI/CLI.hpp>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/stop.h"
#include "libshape/base/to_size.h"
#include "libshape/io/file/output_file.h"
#include "libshape/io/table_file.h"
#include "libshape/model/streamed_fit.h"
#include "libshape/model/streamed_products.h"
#include "libshape/report/score_plot.h"
#include "libshape/statistics/cross_validation.h"
#include "libshape/statistics/discriminant_analysis.h"
#include "libshape/statistics/inner_products.h"
#include "libshape/statistics/principal_components.h"
#include "tools/commands.h"
#include "tools/input/label_input.h"
#include "tools/input/mesh_stream_input.h"
#include "tools/input/repeated_rows.h"
#include "tools/input/space_arguments.h"
#include "tools/output/output_rules.h"
#include "tools/output/pass_store.h"
#include "tools/output/plot_output.h"
#include "tools/program/arguments.h"
#include "tools/program/session.h"

namespace shape::tools {
using namespace internal;
namespace {

constexpr int default_modes = 20;

struct Arguments
{
    LabelledInput input;
    std::string by;
    std::string leave_out;
    std::optional<std::int64_t> modes; ///< Default: default_modes, or as many as the meshes allow.
    std::string output;
    std::string predictions;
    std::string plot;
    PointPlotArguments points; ///< Coloured by the groups.
    SpaceOptions space;
    MemoryArgument memory;
};

/// Rows are true groups, columns predicted ones.
Table confusion_table(const std::string& label, const Grouping& groups,
                      const CrossValidation& result)
{
    Table table;
    table.columns.push_back("true " + label);
    for (const std::string& name : groups.names)
        table.columns.push_back(name);
    for (std::size_t g = 0; g < groups.names.size(); ++g) {
        std::vector<std::string>& row = table.rows.emplace_back();
        row.push_back(groups.names[g]);
        for (const int count : result.confusion.row(static_cast<Eigen::Index>(g)))
            row.push_back(std::to_string(count));
    }
    return table;
}

Table prediction_table(const MeshLabels& meshes, const Grouping& groups, const Grouping& folds,
                       const CrossValidation& result)
{
    Table table{{"mesh", "left_out_with", "true", "predicted"}, {}};
    for (std::size_t i = 0; i < meshes.names.size(); ++i)
        table.rows.push_back({meshes.names[i], folds.names[to_size(folds.group_of[i])],
                              groups.names[to_size(groups.group_of[i])],
                              groups.names[to_size(result.predicted[i])]});
    return table;
}

/// Confusion as lines of text, unless there are too many groups to read.
std::string confusion_text(const Table& table)
{
    std::string text;
    if (table.rows.size() > 12)
        return text;
    const auto add = [&](const std::vector<std::string>& cells) {
        char cell[128];
        for (std::size_t c = 0; c < cells.size(); ++c) {
            std::snprintf(cell, sizeof cell, c == 0 ? "%-16.60s" : " %10.60s", cells[c].c_str());
            text += cell;
        }
        text += "\n";
    };
    add(table.columns);
    for (const std::vector<std::string>& row : table.rows)
        add(row);
    return text;
}

/// The first two canonical variates of all meshes; with two groups, which have but one, against the
/// first mode.
std::string draw_variates(const MeshLabels& meshes, const PointPlotArguments& points,
                          const Grouping& groups, const RowMatrix& scores)
{
    const DiscriminantAnalysis analysis = discriminant_analysis(scores, groups);
    const RowMatrix variates = canonical_variates(analysis, scores);
    const bool has_two = variates.cols() > 1;
    RowMatrix shown(variates.rows(), 2);
    shown << variates.col(0), has_two ? variates.col(1) : scores.col(0);
    Plot plot = score_plot(shown, meshes.names, colouring_values(points, meshes.labels), {},
                           score_plot_options(points));
    plot.x_label = "canonical variate 1";
    plot.y_label = has_two ? "canonical variate 2" : "mode 1";
    return plot_svg(plot);
}

/// With the modes that were asked for; else with the default, or as many as the meshes have.
CrossValidation validate(const Session& session, const Arguments& arguments,
                         const Eigen::MatrixXd& products, const Grouping& groups,
                         const Grouping& folds)
{
    if (arguments.modes)
        return cross_validate(products, groups, folds, static_cast<int>(*arguments.modes));
    CrossValidation result = cross_validate_up_to(products, groups, folds, default_modes);
    if (result.modes < default_modes)
        session.message(join(result.modes, result.modes == 1 ? " mode is" : " modes are",
                             " used, as many as the meshes allow (--modes)"));
    return result;
}

void check_outputs(const Session& session, const Arguments& arguments)
{
    check_ending("-o", arguments.output, ".csv");
    std::vector<std::filesystem::path> taken = input_files(arguments.input.meshes);
    check_output(session, arguments.output, taken);
    if (!arguments.predictions.empty())
        check_ending("--predictions", arguments.predictions, ".csv");
    if (!arguments.plot.empty())
        check_picture("--plot", arguments.plot);
    for (const auto& [option, path] :
         {std::pair{"--predictions", arguments.predictions}, std::pair{"--plot", arguments.plot}})
        if (!path.empty()) {
            check_output(session, path, taken);
            check_different(option, path, "-o", arguments.output);
        }
}

/// What is asked of the meshes, in memory or in passes.
struct Observations
{
    ShapeSpace space;
    Eigen::MatrixXd products;                   ///< N by N inner products about the mean.
    std::function<RowMatrix(int modes)> scores; ///< Of the leading modes of all meshes.
    int passes = 0;                             ///< 0: in memory.
};

/// The groups, told apart, and what is written of it.
void classify_and_write(const Session& session, const Arguments& arguments,
                        const MeshLabels& meshes, const std::function<Observations()>& observe)
{
    const Grouping groups = group_by_label(meshes, arguments.by);
    const Grouping folds = group_by_label_or_each(meshes, arguments.leave_out);
    const RepetitionQuestion rows{.covariates = codes(groups),
                                  .columns = {arguments.by},
                                  .are_groups = true,
                                  .remedy = "then chance looks significant. Give --leave-out",
                                  .unnamed = "a label that names them"};
    const bool are_rows_told =
        !arguments.leave_out.empty() || warn_of_repeated_rows(session, meshes, rows);
    const Observations observed = observe();
    if (!are_rows_told)
        warn_of_close_rows(session, meshes, rows, observed.products);
    throw_if_stop_requested();
    const CrossValidation result = validate(session, arguments, observed.products, groups, folds);
    throw_if_stop_requested();

    const Table confusion = confusion_table(arguments.by, groups, result);
    const std::string plot =
        arguments.plot.empty()
            ? std::string()
            : draw_variates(meshes, arguments.points, groups, observed.scores(result.modes));
    std::vector<std::string> outputs{arguments.output};
    write_table(arguments.output, confusion);
    if (!arguments.predictions.empty()) {
        write_table(arguments.predictions, prediction_table(meshes, groups, folds, result));
        outputs.push_back(arguments.predictions);
    }
    if (!plot.empty()) {
        write_picture(arguments.plot, plot);
        outputs.push_back(arguments.plot);
    }
    const std::size_t count = meshes.names.size();
    const Eigen::VectorXi counts = result.confusion.rowwise().sum();
    const double chance = static_cast<double>(counts.maxCoeff()) / static_cast<double>(count);
    session.message(join(confusion_text(confusion), result.confusion.trace(), " of ", count,
                         " right (", 100.0 * result.accuracy,
                         " %; always naming the largest group: ", 100.0 * chance, " %)"));
    Json figures{{"outputs", outputs}, {"meshes", count}};
    if (observed.passes > 0)
        figures["passes"] = observed.passes;
    figures.update(space_figures(observed.space));
    figures["modes"] = result.modes;
    figures["folds"] = folds.group_count();
    figures["groups"] = groups.names;
    figures["confusion"] = Json::array();
    for (const auto& row : result.confusion.rowwise())
        figures["confusion"].push_back(std::vector<int>(row.begin(), row.end()));
    figures["accuracy"] = result.accuracy;
    figures["chance"] = chance;
    session.print_figures(figures);
}

Observations observe(const Session& session, const Arguments& arguments,
                     const Collection& collection)
{
    Observations observed;
    observed.space = make_space(collection, arguments.space);
    warn_of_alignment(session, observed.space);
    throw_if_stop_requested();
    observed.products = centred_inner_products(encode(observed.space, collection));
    observed.scores = [&collection, space = observed.space](int modes) {
        return principal_components(encode(space, collection), {.modes = modes}).scores;
    };
    return observed;
}

Observations observe_in_passes(const Session& session, const Arguments& arguments,
                               const MeshStream& meshes)
{
    StreamedProducts measured =
        measure_products(meshes, {.space = arguments.space,
                                  .memory = arguments.memory.bytes,
                                  .progress = session.progress(),
                                  .scratch = scratch_folder(arguments.output)});
    Observations observed;
    observed.space = std::move(measured.space);
    observed.products = std::move(measured.products);
    observed.passes = measured.passes;
    observed.scores = [&](int modes) {
        StreamOptions stream;
        stream.memory = arguments.memory.bytes;
        stream.progress = session.progress();
        stream.scratch = scratch_folder(arguments.output);
        return fit_model(meshes, {.modes = modes, .space = arguments.space}, stream).model.scores;
    };
    return observed;
}

void run(const Session& session, const Arguments& arguments)
{
    check_space_options(arguments.space);
    check_outputs(session, arguments);
    if (const auto meshes =
            open_for_passes(session, arguments.input, arguments.space, arguments.memory))
        return classify_and_write(session, arguments, *meshes,
                                  [&] { return observe_in_passes(session, arguments, *meshes); });
    const Collection collection = read_labelled(session, arguments.input);
    classify_and_write(session, arguments, collection,
                       [&] { return observe(session, arguments, collection); });
}

} // namespace

Run set_up_classify(CLI::App& command)
{
    command.description(
        "Tell groups apart in meshes that were not learnt from. Every mesh is assigned to a group\n"
        "by linear discriminants of its scores in the leading modes; mean, modes and\n"
        "discriminants are found anew without the meshes that are left out with it. (Alignment of\n"
        "--space procrustes and --area-weighted know all shapes, but no label.)");
    command.footer(
        "Example:\n"
        "  shape classify faces.h5 --by expression --leave-out subject --modes 20 \\\n"
        "      -o confusion.csv --plot variates.svg");
    const auto arguments = std::make_shared<Arguments>();
    add_labelled_input(command, arguments->input);
    add_label(command, "--by", arguments->by, "Meshes with the same value of it are a group")
        ->required()
        ->option_text("LABEL REQUIRED");
    add_label(command, "--leave-out", arguments->leave_out,
              "Meshes with the same value of it are left out together, such as all of a subject\n"
              "(default: one mesh at a time)");
    add_integer(command, "--modes", arguments->modes,
                "Number of leading modes, >= 1; at most the number of training meshes less that\n"
                "of groups, and as many as these vary in (default: 20, or as many as that)",
                1, std::numeric_limits<int>::max());
    add_output_file(
        command, arguments->output,
        "CSV file to write: a row for each true group, a column for each predicted one,\n"
        "numbers of meshes");
    command
        .add_option("--predictions", arguments->predictions,
                    "CSV file to write: mesh, left_out_with, true, predicted")
        ->option_text("FILE");
    CLI::Option* plot =
        command
            .add_option("--plot", arguments->plot,
                        "Draw all meshes along the first two canonical variates (.svg or .png),\n"
                        "which are fitted to all of them: groups look further apart than they are\n"
                        "for new meshes")
            ->option_text("FILE");
    add_point_plot(command, arguments->points, plot);
    add_space_options(command, arguments->space);
    add_memory(command, arguments->memory);
    return [arguments](const Session& session) {
        arguments->points.color_by = arguments->by;
        run(session, *arguments);
    };
}

} // namespace shape::tools
