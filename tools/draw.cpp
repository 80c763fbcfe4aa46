// SPDX-License-Identifier: MIT

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <numeric>
#include <optional>
#include <set>
#include <tuple>

#include "libshape/base/counted.h"
#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/stop.h"
#include "libshape/base/to_size.h"
#include "libshape/io/file/output_file.h"
#include "libshape/io/label_doubts.h"
#include "libshape/io/label_file.h"
#include "libshape/io/table_file.h"
#include "libshape/io/vertex_scalars.h"
#include "libshape/mesh/oddities.h"
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
    if (found != table.columns.end())
        return to_size(found - table.columns.begin());
    std::vector<std::size_t> all(table.columns.size());
    std::iota(all.begin(), all.end(), 0);
    throw InvalidInput(
        join(path, ": no column '", name, "'; there are ", list_names(table.columns, all)));
}

/// The columns pc1, pc2 and so on, wherever they stand: people add columns of their own.
std::vector<std::size_t> score_columns(const Table& table, const std::string& path)
{
    std::vector<std::size_t> columns{column_of(table, "pc1", path), column_of(table, "pc2", path)};
    const auto is_there = [&](const std::string& name) {
        return std::find(table.columns.begin(), table.columns.end(), name) != table.columns.end();
    };
    for (std::size_t k = 3; is_there(join("pc", k)); ++k)
        columns.push_back(column_of(table, join("pc", k), path));
    return columns;
}

/// The values that colour the points of a table of scores, by the rules of labels; says what is doubtful about them.
std::vector<std::string> colouring_values(const Session& session, const Table& table,
                                          const std::string& label, const std::string& path)
{
    if (label.empty())
        return {};
    LabelColumn colours{label_name(label), {}};
    const std::size_t column = column_of(table, colours.name, path);
    for (const std::vector<std::string>& cells : table.rows)
        colours.values.push_back(label_value(cells[column]));
    for (const std::string& doubt : doubts_about({colours}))
        session.warn(join(path, ": ", doubt));
    return std::move(colours.values);
}

/// The first two scores of the table that `shape project` writes. The shares of the variance are
/// those among the meshes of the table.
Plot read_score_plot(const Session& session, const std::string& path, const std::string& color_by)
{
    const Table table = read_label_table(path);
    const std::size_t mesh = column_of(table, "mesh", path);
    const std::size_t residual = column_of(table, "residual", path);
    const std::vector<std::size_t> modes = score_columns(table, path);
    if (table.rows.empty())
        throw InvalidInput(path + ": there are no scores below the header");
    RowMatrix scores(static_cast<Eigen::Index>(table.rows.size()),
                     static_cast<Eigen::Index>(modes.size()));
    Eigen::VectorXd residuals(scores.rows());
    std::vector<std::string> names;
    std::set<std::string> seen;
    for (Eigen::Index i = 0; i < scores.rows(); ++i) {
        const std::vector<std::string>& cells = table.rows[to_size(i)];
        const std::string& name = names.emplace_back(label_name(cells[mesh]));
        if (!seen.insert(name).second)
            throw InvalidInput(join(path, ": mesh '", name, "' occurs twice; keep one row of it"));
        const auto number = [&](std::size_t column) {
            const std::string place =
                join(path, ", mesh ", name, ", column ", table.columns[column]);
            const std::string value = label_value(cells[column]);
            if (value.empty())
                throw InvalidInput(place + ": the number is missing; leave the row out");
            return parse_number(value, place);
        };
        residuals[i] = number(residual);
        for (Eigen::Index k = 0; k < scores.cols(); ++k)
            scores(i, k) = number(modes[to_size(k)]);
    }
    const RowMatrix centred = scores.rowwise() - scores.colwise().mean();
    const Eigen::VectorXd squares = centred.colwise().squaredNorm();
    const double total = squares.sum() + residuals.squaredNorm();
    return score_plot(scores, names, colouring_values(session, table, color_by, path),
                      total > 0.0 ? Eigen::VectorXd(squares / total) : Eigen::VectorXd(),
                      {.label_name = color_by});
}

/// One value a vertex for every mesh: a property in their PLY files. NaN, which is drawn grey, where there is none.
std::vector<Eigen::VectorXd> read_values(const Session& session, const MeshInput& meshes,
                                         const std::string& property)
{
    std::vector<Eigen::VectorXd> values;
    Eigen::Index vertices = 0;
    Eigen::Index gaps = 0;
    for (const std::filesystem::path& file : mesh_files(meshes)) {
        if (is_collection_file(file))
            throw InvalidInput(join(file.string(),
                                    ": a collection has no values at vertices; "
                                    "--color-by needs PLY files, or --scores"));
        values.push_back(read_vertex_scalar_with_gaps(file, property));
        vertices += values.back().size();
        gaps += values.back().array().isNaN().count();
    }
    if (gaps > 0)
        session.message(join(property, ": ", gaps, " of ", counted(vertices, "vertex", "vertices"),
                             gaps == 1 ? " has" : " have", " no finite value and ",
                             gaps == 1 ? "is" : "are", " grey"));
    return values;
}

/// The range of the colours: as given, or that of all values, which is made symmetric if they have
/// both signs. Nothing if there is none.
std::optional<std::pair<double, double>> value_range(const std::string& text,
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
        return std::pair{low, high};
    }
    double low = std::numeric_limits<double>::infinity();
    double high = -low;
    for (const Eigen::VectorXd& of_mesh : values)
        for (const double value : of_mesh)
            if (!std::isnan(value)) {
                low = std::min(low, value);
                high = std::max(high, value);
            }
    if (low > high)
        return std::nullopt;
    if (low < 0.0 && high > 0.0) {
        high = std::max(-low, high);
        low = -high;
    }
    return std::pair{low, high > low ? high : low + std::max(std::abs(low), 1.0)};
}

/// @return Whether there are values.
bool colour_by_values(const Session& session, PictureOptions& options, const Arguments& arguments)
{
    options.values = read_values(session, arguments.meshes, arguments.color_by);
    const auto range = value_range(arguments.color_range, options.values);
    if (!range)
        return false;
    std::tie(options.value_low, options.value_high) = *range;
    options.value_name = arguments.color_by;
    const bool has_both_signs = options.value_low < 0.0 && options.value_high > 0.0;
    options.colour_map = has_both_signs ? ColourMap::Diverging : ColourMap::Sequential;
    return true;
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
    std::optional<Plot> scores;
    if (!arguments.scores.empty())
        scores = read_score_plot(session, arguments.scores, arguments.color_by);
    const Collection collection = read_meshes(session, arguments.meshes);
    bool has_values = !arguments.color_by.empty() && !scores;
    if (has_values)
        has_values = colour_by_values(session, options, arguments);
    else if (!arguments.color_range.empty())
        throw UsageError("--color-range needs --color-by with a property of the vertices");
    Picture picture = draw_collection(collection, options, session.progress());
    throw_if_stop_requested();
    if (!has_values)
        picture.colour_bar.reset(); // all are grey
    write_file_atomically(output, raster   ? encode_png(picture.sheet)
                                  : scores ? overview_svg(picture, *scores)
                                           : picture_svg(picture));
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
        .add_option(
            "--color-by", arguments->color_by,
            "With --scores: column that colours them. Else: property of the vertices of\n"
            "PLY files that colours the meshes, as --residuals and --effects write them, or\n"
            "x, y or z; vertices without a finite value are grey")
        ->option_text("NAME");
    command
        .add_option("--color-range", arguments->color_range,
                    "Values of the first and the last colour (default: the least and the largest\n"
                    "of all; symmetric about 0 if they have both signs)")
        ->option_text("LOW:HIGH");
    return [arguments](const Session& session) { run(session, *arguments); };
}

} // namespace shape::tools
