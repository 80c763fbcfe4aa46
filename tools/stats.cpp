// SPDX-License-Identifier: MIT

#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>

#include "libshape/base/format.h"
#include "libshape/io/model_file.h"
#include "libshape/model/shape_model.h"
#include "tools/commands.h"
#include "tools/common/arguments.h"
#include "tools/common/interrupt.h"
#include "tools/common/mesh_input.h"
#include "tools/common/model_tables.h"
#include "tools/common/output_rules.h"
#include "tools/common/session.h"
#include "tools/common/space_arguments.h"

namespace shape::tools {
namespace {

struct Arguments
{
    MeshInput meshes;
    std::string output;
    std::int64_t modes = 0;
    double variance = 1.0;
    SpaceOptions space = {};
};

void run(const Session& session, const Arguments& arguments)
{
    check_space_options(arguments.space);
    check_ending("-o", arguments.output, ".h5");
    check_output(session, arguments.output, input_files(arguments.meshes));
    const Collection collection = read_meshes(session, arguments.meshes);
    const ShapeModel model = fit_model(collection, {.modes = static_cast<int>(arguments.modes),
                                                    .variance = arguments.variance,
                                                    .space = arguments.space});
    warn_of_alignment(session, model.space);
    throw_if_interrupted();
    write_model(arguments.output, model);
    session.message(join(arguments.output, ": ", model.mode_count(), " modes of ",
                         collection.size(), " meshes\n", mode_table(model)));
    Json figures{{"outputs", {arguments.output}},
                 {"meshes", collection.size()},
                 {"vertices", model.topology.vertex_count()},
                 {"edges", model.topology.edge_count()}};
    figures.update(space_figures(model.space));
    figures["mean_size"] = model.mean_size();
    figures["total_variance"] = model.total_variance;
    figures["modes"] = mode_figures(model);
    session.print_figures(figures);
}

} // namespace

Run set_up_stats(CLI::App& command)
{
    command.description(
        "Fit a statistical model of meshes in correspondence: the mean in a space of shapes, the\n"
        "principal modes with their variances (divisor N - 1), and the scores of the meshes.");
    command.footer(
        "Examples:\n"
        "  shape stats faces.h5 -o model.h5 --variance 0.95\n"
        "  shape stats faces.h5 -o aligned.h5 --space procrustes");
    const auto arguments = std::make_shared<Arguments>();
    add_mesh_input(command, arguments->meshes);
    add_labels(command, arguments->meshes);
    add_output_file(command, arguments->output, "Model to write (.h5)");
    CLI::Option* modes =
        add_integer(command, "--modes", arguments->modes,
                    "Number of modes to keep, [1, N - 1] (default: all with any variance)", 1,
                    std::numeric_limits<int>::max());
    add_number(command, "--variance", arguments->variance,
               "Keep the fewest modes with this share of the total variance, (0, 1]",
               Sign::Positive)
        ->excludes(modes);
    add_space_options(command, arguments->space);
    return [arguments](const Session& session) { run(session, *arguments); };
}

} // namespace shape::tools
