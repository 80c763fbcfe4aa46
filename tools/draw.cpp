// SPDX-License-Identifier: MIT

#include <CLI/CLI.hpp>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <tuple>

#include "libshape/base/counted.h"
#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/stop.h"
#include "libshape/base/to_size.h"
#include "libshape/io/file/output_file.h"
#include "libshape/io/table_file.h"
#include "libshape/io/vertex_scalars.h"
#include "libshape/report/picture.h"
#include "libshape/report/score_plot.h"
#include "tools/commands.h"
#include "tools/input/mesh_input.h"
#include "tools/output/output_rules.h"
#include "tools/program/arguments.h"
#include "tools/program/session.h"

namespace shape::tools {
using namespace internal;
namespace {

struct Arguments
{
    MeshInput meshes;
    std::string output;
    std::string scores;
    std::string color_by;
    std::string color_range;
    std::string view;
    bool sequence = false;
    std::int64_t columns = 0;
    std::int64_t cell = 200;
};

std::size_t column_of(const Table& table, const std::string& name, const std::string& path)
{
    const auto found = std::find(table.columns.begin(), table.columns.end(), name);
    if (found == table.columns.end())
        throw InvalidInput(join(path, ": no column '", name, "'"));
    return to_size(found - table.columns.begin());
}

/// The first two scores of the table that `shape project` writes. The shares of the variance are
/// those among the meshes of the table.
Plot read_score_plot(const std::string& path, const std::string& color_by)
{
    const Table table = read_table(path);
    const std::size_t mesh = column_of(table, "mesh", path);
    const std::size_t residual = column_of(table, "residual", path);
    const std::size_t first = column_of(table, "pc1", path);
    (void)column_of(table, "pc2", path);
    const auto count = static_cast<Eigen::Index>(table.rows.size());
    RowMatrix scores(count, static_cast<Eigen::Index>(table.columns.size() - first));
    Eigen::VectorXd residuals(count);
    std::vector<std::string> names;
    std::vector<std::string> values;
    for (Eigen::Index i = 0; i < count; ++i) {
        const std::vector<std::string>& cells = table.rows[to_size(i)];
        const std::string place = join(path, ", row ", i + 1);
        names.push_back(cells[mesh]);
        if (!color_by.empty())
            values.push_back(cells[column_of(table, color_by, path)]);
        residuals[i] = parse_number(cells[residual], place);
        for (Eigen::Index k = 0; k < scores.cols(); ++k)
            scores(i, k) = parse_number(cells[first + to_size(k)], place);
    }
    const RowMatrix centred = scores.rowwise() - scores.colwise().mean();
    const Eigen::VectorXd squares = centred.colwise().squaredNorm();
    const double total = squares.sum() + residuals.squaredNorm();
    return score_plot(scores, names, values,
                      total > 0.0 ? Eigen::VectorXd(squares / total) : Eigen::VectorXd(),
                      {.label_name = color_by});
}

/// One value a vertex for every mesh: a property in their PLY files.
std::vector<Eigen::VectorXd> read_values(const MeshInput& meshes, const std::string& property)
{
    std::vector<Eigen::VectorXd> values;
    for (const std::filesystem::path& file : mesh_files(meshes)) {
        if (is_collection_file(file))
            throw InvalidInput(join(file.string(),
                                    ": a collection has no values at vertices; "
                                    "--color-by needs PLY files, or --scores"));
        values.push_back(read_vertex_scalar(file, property));
    }
    return values;
}

/// The range of the colours: as given, or that of all values, which is made symmetric if they have
/// both signs.
std::pair<double, double> value_range(const std::string& text,
                                      const std::vector<Eigen::VectorXd>& values)
{
    if (!text.empty()) {
        const std::vector<std::string> ends = split(text, ':');
        if (ends.size() != 2)
            throw UsageError(join("--color-range: '", text, "' must be LOW:HIGH"));
        const double low = read_number(ends[0], "--color-range");
        const double high = read_number(ends[1], "--color-range");
        if (!(low < high))
            throw UsageError(join("--color-range: ", text, ": LOW must be below HIGH"));
        return {low, high};
    }
    double low = values.front().minCoeff();
    double high = values.front().maxCoeff();
    for (const Eigen::VectorXd& of_mesh : values) {
        low = std::min(low, of_mesh.minCoeff());
        high = std::max(high, of_mesh.maxCoeff());
    }
    if (low < 0.0 && high > 0.0) {
        high = std::max(-low, high);
        low = -high;
    }
    return {low, high > low ? high : low + std::max(std::abs(low), 1.0)};
}

void colour_by_values(PictureOptions& options, const Arguments& arguments)
{
    options.values = read_values(arguments.meshes, arguments.color_by);
    std::tie(options.value_low, options.value_high) =
        value_range(arguments.color_range, options.values);
    options.value_name = arguments.color_by;
    const bool has_both_signs = options.value_low < 0.0 && options.value_high > 0.0;
    options.colour_map = has_both_signs ? ColourMap::Diverging : ColourMap::Sequential;
}

ViewDirection read_view(const std::string& text)
{
    const std::vector<double> angles = read_numbers(text, "--view");
    if (angles.size() != 2 || std::abs(angles[1]) > 90.0)
        throw UsageError("--view takes azimuth,elevation in degrees, elevation in [-90, 90]");
    return {.azimuth = angles[0], .elevation = angles[1]};
}

void run(const Session& session, const Arguments& arguments)
{
    const std::filesystem::path output = arguments.output;
    const bool raster = has_ending(output, ".png");
    if (!raster && !has_ending(output, ".svg"))
        throw UsageError(join("-o is '", arguments.output, "', must end in .svg or .png"));
    if (raster && !arguments.scores.empty())
        throw UsageError("--scores needs text; let -o end in .svg");
    std::vector<std::filesystem::path> inputs = input_files(arguments.meshes);
    if (!arguments.scores.empty())
        inputs.emplace_back(arguments.scores);
    check_output(session, output, inputs);

    PictureOptions options;
    options.columns = static_cast<int>(arguments.columns);
    options.cell_width = static_cast<int>(arguments.cell);
    options.is_sequence = arguments.sequence;
    if (!arguments.view.empty())
        options.view = read_view(arguments.view);
    const Collection collection = read_meshes(session, arguments.meshes);
    const bool has_values = !arguments.color_by.empty() && arguments.scores.empty();
    if (has_values)
        colour_by_values(options, arguments);
    else if (!arguments.color_range.empty())
        throw UsageError("--color-range needs --color-by with a property of the vertices");
    const Picture picture = draw_collection(collection, options, session.progress());
    throw_if_stop_requested();
    write_file_atomically(
        output, raster ? encode_png(picture.sheet)
                : arguments.scores.empty()
                    ? picture_svg(picture)
                    : overview_svg(picture, read_score_plot(arguments.scores, arguments.color_by)));
    session.message(join(arguments.output, ": ", counted(collection.size(), "mesh", "meshes")));
    if (has_values)
        session.message(join(arguments.color_by, ": colours from ", options.value_low, " to ",
                             options.value_high));
    Json figures{{"outputs", {arguments.output}},
                 {"meshes", collection.size()},
                 {"width_px", std::lround(picture.width())},
                 {"height_px", std::lround(picture.height())}};
    if (has_values)
        figures["color_range"] = {options.value_low, options.value_high};
    session.print_figures(figures);
}

} // namespace

Run set_up_draw(CLI::App& command)
{
    command.description(
        "Draw meshes side by side in one picture: all from one side, at one scale, each moved\n"
        "rigidly onto the first. SVG has the names below the meshes and room for a plot of\n"
        "scores; PNG has the meshes alone.");
    command.footer(
        "Example:\n  shape draw mean.ply mode1/ --columns 3 -o modes.svg\n"
        "  shape draw mode1/ mode2/ --scores scores.csv --color-by expression -o overview.svg\n"
        "  shape draw residuals/mean_residuals.ply --color-by edge_error -o residuals.svg");
    const auto arguments = std::make_shared<Arguments>();
    add_mesh_input(command, arguments->meshes);
    arguments->meshes.may_repeat = true;
    add_output_file(command, arguments->output, "Picture to write (.svg or .png)");
    add_integer(command, "--columns", arguments->columns,
                "Meshes in a row (default: as many as fit 1200 px)", 1, 10000);
    add_integer(command, "--cell", arguments->cell,
                "Width of a cell [px] in [16, 4096] (default: 200)", 16, 4096);
    command.add_option("--view", arguments->view,
                       "Where the viewer stands: azimuth,elevation [deg]; 0,0 looks from +z, 90,0\n"
                       "from +x, 0,90 from +y (default: along the thinnest direction)");
    command.add_flag("--sequence", arguments->sequence,
                     "Move each mesh onto the one before it, not onto the first: for frames that\n"
                     "go far, whose best fit to the first may be turned over");
    command.add_option("--scores", arguments->scores,
                       "Scores written by `shape project`: pc1 and pc2 are plotted below");
    command
        .add_option("--color-by", arguments->color_by,
                    "With --scores: column that colours them. Else: property of the vertices of\n"
                    "PLY files that colours the meshes, as --residuals and --effects write them")
        ->option_text("NAME");
    command
        .add_option("--color-range", arguments->color_range,
                    "Values of the first and the last colour (default: the least and the largest\n"
                    "of all; symmetric about 0 if they have both signs)")
        ->option_text("LOW:HIGH");
    return [arguments](const Session& session) { run(session, *arguments); };
}

} // namespace shape::tools
