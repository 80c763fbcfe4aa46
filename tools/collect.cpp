// SPDX-License-Identifier: MIT

#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>

#include "libshape/base/counted.h"
#include "libshape/base/format.h"
#include "libshape/io/collection_file.h"
#include "tools/commands.h"
#include "tools/input/label_input.h"
#include "tools/output/output_rules.h"
#include "tools/program/session.h"

namespace shape::tools {
using namespace internal;
namespace {

struct Arguments
{
    LabelledInput input;
    std::string output;
};

void run(const Session& session, const Arguments& arguments)
{
    check_ending("-o", arguments.output, ".h5");
    check_output(session, arguments.output, input_files(arguments.input.meshes));
    const Collection collection = read_labelled(session, arguments.input);
    write_collection(arguments.output, collection);
    session.message(join(arguments.output, ": ", counted(collection.size(), "mesh", "meshes"),
                         " of ", collection.topology.vertex_count(), " vertices"));
    session.print_figures({{"outputs", {arguments.output}},
                           {"meshes", collection.size()},
                           {"vertices", collection.topology.vertex_count()},
                           {"edges", collection.topology.edge_count()},
                           {"faces", collection.topology.face_count()}});
}

} // namespace

Run set_up_collect(CLI::App& command)
{
    command.description(
        "Check that meshes are in correspondence (one triangulation, the same vertex and face\n"
        "order) and write them, with edge lengths, dihedral angles and labels, as one collection.");
    command.footer("Example:\n  shape collect faces/ -o faces.h5 --labels faces/labels.csv");
    const auto arguments = std::make_shared<Arguments>();
    add_labelled_input(command, arguments->input);
    add_output_file(command, arguments->output, "Collection to write (.h5)");
    return [arguments](const Session& session) { run(session, *arguments); };
}

} // namespace shape::tools
