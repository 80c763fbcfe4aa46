// SPDX-License-Identifier: MIT

#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>

#include "libshape/base/counted.h"
#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/stop.h"
#include "libshape/base/to_size.h"
#include "libshape/io/file/output_file.h"
#include "libshape/io/model_file.h"
#include "libshape/model/shape_model.h"
#include "libshape/model/unlike_meshes.h"
#include "libshape/report/score_plot.h"
#include "tools/commands.h"
#include "tools/input/label_input.h"
#include "tools/input/mesh_stream_input.h"
#include "tools/output/mesh_table.h"
#include "tools/output/output_rules.h"
#include "tools/output/plot_output.h"
#include "tools/output/unlike_warnings.h"
#include "tools/program/arguments.h"
#include "tools/program/ranks.h"
#include "tools/program/session.h"

namespace shape::tools {
using namespace internal;
namespace {

struct Arguments
{
    std::string model;
    LabelledInput input;
    std::string output;
    std::string plot;
    std::string axes = "1,2";
    bool equal_scales = false;
    PointPlotArguments points;
};

/// Columns `mesh`, the labels, `size`, `residual`, `pc1`, `pc2`, ...
Table score_table(const Projection& projection)
{
    Table table = mesh_table(projection.names, projection.labels);
    add_column(table, "size", projection.sizes);
    add_column(table, "residual", projection.residuals);
    for (Eigen::Index k = 0; k < projection.scores.cols(); ++k)
        add_column(table, join("pc", k + 1), projection.scores.col(k));
    check_columns(table);
    return table;
}

/// The two modes of --axes, from 0.
std::pair<int, int> axes_of(const Arguments& arguments, int modes)
{
    const std::vector<double> axes = read_numbers(arguments.axes, "--axes");
    const auto is_mode = [&](double axis) {
        return axis >= 1.0 && axis <= modes && axis == std::floor(axis);
    };
    if (axes.size() != 2 || !std::ranges::all_of(axes, is_mode) || axes[0] == axes[1])
        throw UsageError(join("--axes: '", arguments.axes, "' must be two different modes in [1, ",
                              modes, "], such as 2,3"));
    return {static_cast<int>(axes[0]) - 1, static_cast<int>(axes[1]) - 1};
}

/// Two scores as an SVG document, coloured by a label if one is named.
std::string draw_scores(const Arguments& arguments, const ShapeModel& model,
                        const Projection& projection)
{
    if (model.mode_count() < 2)
        throw InvalidInput(join("--plot needs two modes, ", arguments.model, " has one"));
    ScorePlotOptions options = score_plot_options(arguments.points);
    std::tie(options.mode_x, options.mode_y) = axes_of(arguments, model.mode_count());
    options.equal_axes = arguments.equal_scales;
    return plot_svg(score_plot(projection.scores, projection.names,
                               colouring_values(arguments.points, projection.labels),
                               model.variances / model.total_variance, options));
}

void check_outputs(const Session& session, const Arguments& arguments)
{
    std::vector<std::filesystem::path> inputs = input_files(arguments.input.meshes);
    inputs.emplace_back(arguments.model);
    check_ending("-o", arguments.output, ".csv");
    check_output(session, arguments.output, inputs);
    if (arguments.plot.empty())
        return;
    check_picture("--plot", arguments.plot);
    check_output(session, arguments.plot, inputs);
}

/// Scores, and what else is unlike the model's meshes (unlike_meshes()).
struct Projected
{
    Projection scores;
    RowMatrix marks;
};

/// A large collection comes by block by block; the scores of a mesh do not depend on the others.
Projected project_in_blocks(const Session& session, const ShapeModel& model,
                            const MeshStream& meshes)
{
    const Eigen::Index count = meshes.size();
    Projection all{.names = meshes.names,
                   .labels = meshes.labels,
                   .scores = RowMatrix::Zero(count, model.mode_count()),
                   .sizes = Eigen::VectorXd::Zero(count),
                   .residuals = Eigen::VectorXd::Zero(count)};
    RowMatrix marks = RowMatrix::Zero(count, 2);
    const KnownMeshes known = known_meshes(model);
    const Progress progress = session.progress();
    constexpr Eigen::Index block = 32; // as project() goes about it: the same bits
    const Eigen::Index blocks = (count + block - 1) / block;
    const auto border = [&](int rank) { // each process has as many blocks
        return std::min(blocks * rank / ranks().count * block, count);
    };
    const Eigen::Index begin = border(ranks().number);
    const Eigen::Index end = border(ranks().number + 1);
    for_each_block(meshes, begin, end, block, [&](Eigen::Index first, const Collection& part) {
        Collection named = part;
        named.names.assign(meshes.names.begin() + first,
                           meshes.names.begin() + first + static_cast<Eigen::Index>(part.size()));
        const Projection some = project(model, named);
        all.scores.middleRows(first, some.scores.rows()) = some.scores;
        all.sizes.segment(first, some.sizes.size()) = some.sizes;
        all.residuals.segment(first, some.sizes.size()) = some.residuals;
        marks.middleRows(first, some.sizes.size()) = unlike_meshes(known, named, some.sizes);
        progress("projecting", to_size(first - begin) + part.size(), to_size(end - begin));
    });
    ranks().all_reduce_sum({all.scores.data(), to_size(all.scores.size())});
    ranks().all_reduce_sum({all.sizes.data(), to_size(all.sizes.size())});
    ranks().all_reduce_sum({all.residuals.data(), to_size(all.residuals.size())});
    ranks().all_reduce_sum({marks.data(), to_size(marks.size())});
    return {std::move(all), std::move(marks)};
}

Projected project_all(const Session& session, const Arguments& arguments, const ShapeModel& model)
{
    LabelledInput input = arguments.input;
    input.meshes.known =
        NamedMesh{arguments.model, arguments.model, model.reference_points, model.topology.faces()};
    if (const auto meshes = open_labelled(session, input, ranks().partial_sums > 1))
        return project_in_blocks(session, model, *meshes);
    if (ranks().partial_sums > 1)
        throw UsageError("mpirun is for one collection file (.h5); `shape collect` makes one");
    const Collection meshes = read_labelled(session, input);
    Projection scores = project(model, meshes);
    RowMatrix marks = unlike_meshes(known_meshes(model), meshes, scores.sizes);
    return {std::move(scores), std::move(marks)};
}

void run(const Session& session, const Arguments& arguments)
{
    check_outputs(session, arguments);
    const ShapeModel model = read_model(arguments.model);
    const Projected projected = project_all(session, arguments, model);
    if (!ranks().is_root())
        return;
    const Projection& projection = projected.scores;
    warn_of_unlike(session, projection.names, projected.marks,
                   {.others = join("the meshes of ", arguments.model),
                    .mirrored = effect_of_mirroring(model.space)});
    warn_of_far(session, projection.names, far_meshes(model, projection),
                join("the meshes of ", arguments.model));
    const Table table = score_table(projection);
    std::vector<std::string> outputs{arguments.output};
    const std::string plot =
        arguments.plot.empty() ? std::string() : draw_scores(arguments, model, projection);
    throw_if_stop_requested();
    write_table(arguments.output, table);
    if (!plot.empty()) {
        write_picture(arguments.plot, plot);
        outputs.push_back(arguments.plot);
    }
    session.message(join(arguments.output, ": scores of ",
                         counted(projection.names.size(), "mesh", "meshes"), " in ",
                         counted(model.mode_count(), "mode"), ", largest residual ",
                         projection.residuals.maxCoeff()));
    session.print_figures({{"outputs", outputs},
                           {"meshes", projection.names.size()},
                           {"modes", model.mode_count()},
                           {"largest_residual", projection.residuals.maxCoeff()}});
}

} // namespace

Run set_up_project(CLI::App& command)
{
    command.description(
        "Write the scores of meshes, old or new, in a model, in the space it was fitted in (new\n"
        "meshes are aligned with the mean of a Procrustes model). A score (pc1, pc2, ...) is the\n"
        "coordinate along the mode, not in standard deviations: its variance over the meshes of\n"
        "the model is the variance of the mode. `size` is the sum of the edge lengths, in\n"
        "Procrustes space the centroid size [unit of the input], `residual` the distance to the\n"
        "span of the modes, in the unit of the scores.");
    command.footer(
        "Example:\n"
        "  shape project model.h5 faces.h5 -o scores.csv --plot scores.svg --color-by mood");
    const auto arguments = std::make_shared<Arguments>();
    command.add_option("MODEL", arguments->model, "Model made by `shape stats` (.h5)")
        ->required()
        ->option_text("REQUIRED");
    add_labelled_input(command, arguments->input);
    add_output_file(command, arguments->output,
                    "CSV file to write: mesh, labels, size, residual, pc1, pc2, ...");
    CLI::Option* plot = command
                            .add_option("--plot", arguments->plot,
                                        "Draw two scores, one point a mesh (.svg or .png)")
                            ->option_text("FILE");
    command
        .add_option(
            "--color-by", arguments->points.color_by,
            "Label that colours the plot: numbers by a scale; other values by a colour and\n"
            "a mark each, of more than 12 values the 11 largest, the rest in grey")
        ->option_text("LABEL")
        ->needs(plot);
    command
        .add_option("--axes", arguments->axes,
                    "Modes on the horizontal and on the vertical axis (default: 1,2)")
        ->option_text("K,L")
        ->needs(plot);
    command
        .add_flag("--equal-scales", arguments->equal_scales,
                  "Scale both axes alike, so that distances can be compared")
        ->needs(plot);
    add_point_plot(command, arguments->points, plot);
    return [arguments](const Session& session) { run(session, *arguments); };
}

} // namespace shape::tools
