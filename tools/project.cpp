// SPDX-License-Identifier: MIT

#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/io/model_file.h"
#include "libshape/io/table_file.h"
#include "libshape/model/shape_model.h"
#include "tools/commands.h"
#include "tools/common/interrupt.h"
#include "tools/common/mesh_input.h"
#include "tools/common/output_rules.h"
#include "tools/common/session.h"

namespace shape::tools {
namespace {

struct Arguments
{
    std::string model;
    MeshInput meshes;
    std::string output;
};

/// Columns `mesh`, the labels, `size`, `residual`, `pc1`, `pc2`, ...
Table score_table(const Projection& projection)
{
    Table table;
    table.columns.push_back("mesh");
    for (const LabelColumn& label : projection.labels)
        table.columns.push_back(label.name);
    table.columns.insert(table.columns.end(), {"size", "residual"});
    for (Eigen::Index k = 0; k < projection.scores.cols(); ++k)
        table.columns.push_back(join("pc", k + 1));
    for (std::size_t i = 0; i < projection.names.size(); ++i) {
        const auto row = static_cast<Eigen::Index>(i);
        std::vector<std::string>& cells = table.rows.emplace_back();
        cells.push_back(projection.names[i]);
        for (const LabelColumn& label : projection.labels)
            cells.push_back(label.values[i]);
        cells.push_back(print_number(projection.sizes[row]));
        cells.push_back(print_number(projection.residuals[row]));
        for (const double score : projection.scores.row(row))
            cells.push_back(print_number(score));
    }
    return table;
}

/// A label may not have the name of another column.
void check_columns(const Table& table)
{
    std::set<std::string> seen;
    for (const std::string& column : table.columns)
        if (!seen.insert(column).second)
            throw InvalidInput(join("the label '", column,
                                    "' has the name of another column of the scores; rename it"));
}

void run(const Session& session, const Arguments& arguments)
{
    std::vector<std::filesystem::path> inputs = input_files(arguments.meshes);
    inputs.push_back(arguments.model);
    check_output(session, arguments.output, inputs);
    const ShapeModel model = read_model(arguments.model);
    const Projection projection = project(model, read_meshes(session, arguments.meshes));
    const Table table = score_table(projection);
    check_columns(table);
    throw_if_interrupted();
    write_table(arguments.output, table);
    session.message(join(arguments.output, ": scores of ", projection.names.size(), " meshes in ",
                         model.mode_count(), " modes, largest residual ",
                         projection.residuals.maxCoeff()));
    session.print_figures({{"outputs", {arguments.output}},
                           {"meshes", projection.names.size()},
                           {"modes", model.mode_count()},
                           {"largest_residual", projection.residuals.maxCoeff()}});
}

} // namespace

Run set_up_project(CLI::App& command)
{
    command.description(
        "Write the scores of meshes, old or new, in a model. A score (pc1, pc2, ...) is the\n"
        "coordinate along the mode, not in standard deviations: its variance over the meshes of\n"
        "the model is the variance of the mode. `size` is the sum of the edge lengths [unit of\n"
        "the input], `residual` the distance to the span of the modes, in the unit of the scores\n"
        "(lengths divided by their sum, or lengths for a model of --scale none).");
    command.footer("Example:\n  shape project model.h5 faces.h5 -o scores.csv");
    const auto arguments = std::make_shared<Arguments>();
    command.add_option("MODEL", arguments->model, "Model made by `shape stats` (.h5)")
        ->required()
        ->option_text("REQUIRED");
    add_mesh_input(command, arguments->meshes);
    add_labels(command, arguments->meshes);
    add_output_file(command, arguments->output,
                    "CSV file to write: mesh, labels, size, residual, pc1, pc2, ...");
    return [arguments](const Session& session) { run(session, *arguments); };
}

} // namespace shape::tools
