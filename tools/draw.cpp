// SPDX-License-Identifier: MIT

#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/io/output_file.h"
#include "libshape/io/table_file.h"
#include "libshape/report/picture.h"
#include "tools/commands.h"
#include "tools/common/arguments.h"
#include "tools/common/interrupt.h"
#include "tools/common/mesh_input.h"
#include "tools/common/output_rules.h"
#include "tools/common/session.h"

namespace shape::tools {
namespace {

struct Arguments
{
    MeshInput meshes;
    std::string output;
    std::string scores;
    std::string color_by;
    std::string view;
    std::int64_t columns = 0;
    std::int64_t cell = 200;
};

std::size_t column_of(const Table& table, const std::string& name, const std::string& path)
{
    const auto found = std::find(table.columns.begin(), table.columns.end(), name);
    if (found == table.columns.end())
        throw InvalidInput(join(path, ": no column '", name, "'"));
    return static_cast<std::size_t>(found - table.columns.begin());
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
        const std::vector<std::string>& cells = table.rows[static_cast<std::size_t>(i)];
        const std::string place = join(path, ", row ", i + 1);
        names.push_back(cells[mesh]);
        if (!color_by.empty())
            values.push_back(cells[column_of(table, color_by, path)]);
        residuals[i] = parse_number(cells[residual], place);
        for (Eigen::Index k = 0; k < scores.cols(); ++k)
            scores(i, k) = parse_number(cells[first + static_cast<std::size_t>(k)], place);
    }
    const RowMatrix centred = scores.rowwise() - scores.colwise().mean();
    const Eigen::VectorXd squares = centred.colwise().squaredNorm();
    const double total = squares.sum() + residuals.squaredNorm();
    return score_plot(scores, names, values,
                      total > 0.0 ? Eigen::VectorXd(squares / total) : Eigen::VectorXd());
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
    const bool raster = output.extension() == ".png";
    if (!raster && output.extension() != ".svg")
        throw UsageError(join("-o is '", arguments.output, "', must end in .svg or .png"));
    if (raster && !arguments.scores.empty())
        throw UsageError("--scores needs text; let -o end in .svg");
    std::vector<std::filesystem::path> inputs = input_files(arguments.meshes);
    if (!arguments.scores.empty())
        inputs.push_back(arguments.scores);
    check_output(session, output, inputs);

    PictureOptions options;
    options.columns = static_cast<int>(arguments.columns);
    options.cell_width = static_cast<int>(arguments.cell);
    if (!arguments.view.empty())
        options.view = read_view(arguments.view);
    const Collection collection = read_meshes(session, arguments.meshes);
    const Picture picture = draw_collection(collection, options);
    throw_if_interrupted();
    write_file_atomically(
        output, raster ? encode_png(picture.sheet)
                : arguments.scores.empty()
                    ? picture_svg(picture)
                    : overview_svg(picture, read_score_plot(arguments.scores, arguments.color_by)));
    session.message(join(arguments.output, ": ", collection.size(), " meshes"));
    session.print_figures({{"outputs", {arguments.output}},
                           {"meshes", collection.size()},
                           {"width_px", picture.width()},
                           {"height_px", picture.height()}});
}

} // namespace

Run set_up_draw(CLI::App& command)
{
    command.description(
        "Draw meshes side by side in one picture, all from one side, at one scale, each moved "
        "rigidly\n"
        "onto the first. SVG has the names below the meshes and room for a plot of scores; PNG "
        "has\n"
        "the meshes alone.");
    command.footer(
        "Example:\n  shape draw mean.ply mode1/ --columns 3 -o modes.svg\n"
        "  shape draw mode1/ mode2/ --scores scores.csv --color-by expression -o overview.svg");
    const auto arguments = std::make_shared<Arguments>();
    add_mesh_input(command, arguments->meshes);
    add_output_file(command, arguments->output, "Picture to write (.svg or .png)");
    add_integer(command, "--columns", arguments->columns,
                "Meshes in a row (default: as many as fit 1200 px)", 1, 10000);
    add_integer(command, "--cell", arguments->cell,
                "Width of a cell [px] in [16, 4096] (default: 200)", 16, 4096);
    command.add_option("--view", arguments->view,
                       "Where the viewer stands: azimuth,elevation [deg]; 0,0 looks from +z, 90,0\n"
                       "from +x, 0,90 from +y (default: along the thinnest direction)");
    CLI::Option* scores =
        command.add_option("--scores", arguments->scores,
                           "Scores written by `shape project`: pc1 and pc2 are plotted below");
    command.add_option("--color-by", arguments->color_by, "Column of the scores that colours them")
        ->needs(scores);
    return [arguments](const Session& session) { run(session, *arguments); };
}

} // namespace shape::tools
