// SPDX-License-Identifier: MIT

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "libshape/base/counted.h"
#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/to_size.h"
#include "libshape/io/collection_file.h"
#include "libshape/io/collection_stream.h"
#include "libshape/mesh/oddities.h"
#include "tools/commands.h"
#include "tools/input/label_input.h"
#include "tools/input/mesh_stream_input.h"
#include "tools/output/output_rules.h"
#include "tools/program/arguments.h"
#include "tools/program/session.h"

namespace shape::tools {
using namespace internal;
namespace {

struct Arguments
{
    LabelledInput input;
    std::string output;
    bool append = false;
    CollectionFileOptions file = {};
};

void report(const Session& session, const Arguments& arguments, const Topology& topology,
            Eigen::Index meshes)
{
    session.message(join(arguments.output, ": ", counted(to_size(meshes), "mesh", "meshes"), " of ",
                         topology.vertex_count(), " vertices"));
    session.print_figures({{"outputs", {arguments.output}},
                           {"meshes", meshes},
                           {"vertices", topology.vertex_count()},
                           {"edges", topology.edge_count()},
                           {"faces", topology.face_count()}});
}

/// Warns of meshes that are added and are odd beside the first one that is there.
void warn_of_oddities(const Session& session, const MeshStream& present, const Collection& added)
{
    Collection together{added.topology, added.names, added.points, {}};
    together.names.push_back(present.names.front());
    together.points.emplace_back(added.topology.vertex_count(), 3);
    present.fetch({0})(std::span(together.points).last(1));
    for (const Oddity& oddity : find_oddities(together))
        if (oddity.kind == OddityKind::Mirrored || oddity.kind == OddityKind::Size ||
            (oddity.kind == OddityKind::Copies && oddity.meshes.back() == added.size()))
            session.warn(advice_on(oddity));
}

/// The meshes of the output and those that are added to it: positions that are there are passed on
/// as they are.
void append(const Session& session, const Arguments& arguments)
{
    const MeshStream present = open_collection(arguments.output);
    for (const std::filesystem::path& path : input_files(arguments.input.meshes))
        if (std::filesystem::equivalent(path, arguments.output))
            throw UsageError(join(arguments.output, ": the output is an input of the run"));
    const Collection added = read_labelled(session, arguments.input);
    if (!(added.topology == present.topology)) {
        std::vector<Points> first(1, Points(present.topology.vertex_count(), 3));
        present.fetch({0})(first);
        throw InvalidInput(describe_correspondence_break(
            {present.names.front(), join(arguments.output, ": mesh ", present.names.front()),
             first.front(), present.topology.faces()},
            {added.names.front(), "mesh " + added.names.front(), added.points.front(),
             added.topology.faces()}));
    }
    warn_of_oddities(session, present, added);
    const Eigen::Index meshes = append_to_collection(arguments.output, stream_of(added),
                                                     arguments.file, session.progress());
    report(session, arguments, added.topology, meshes);
}

void run(const Session& session, const Arguments& arguments)
{
    check_ending("-o", arguments.output, ".h5");
    check_stored_labels(arguments.input.meshes);
    if (arguments.append)
        return append(session, arguments);
    check_output(session, arguments.output, input_files(arguments.input.meshes));
    if (const auto meshes = open_labelled(session, arguments.input, false)) {
        write_collection(arguments.output, *meshes, arguments.file, session.progress());
        return report(session, arguments, meshes->topology, meshes->size());
    }
    const Collection collection = read_labelled(session, arguments.input);
    write_collection(arguments.output, collection, arguments.file);
    report(session, arguments, collection.topology, static_cast<Eigen::Index>(collection.size()));
}

} // namespace

Run set_up_collect(CLI::App& command)
{
    command.description(
        "Check that meshes are in correspondence (one triangulation, the same vertex and face\n"
        "order) and write their positions and labels as one collection. Lengths and angles are\n"
        "measured when they are needed.");
    command.footer(
        "Examples:\n"
        "  shape collect faces/ -o faces.h5 --labels faces/labels.csv\n"
        "  shape collect more/ --append -o faces.h5");
    const auto arguments = std::make_shared<Arguments>();
    add_labelled_input(command, arguments->input);
    add_output_file(command, arguments->output, "Collection to write (.h5)");
    command.add_flag(
        "--append", arguments->append,
        "Add the meshes to the collection that is there, which is replaced as a whole\n"
        "when all is written; its own are copied, not measured or checked again. What was\n"
        "stored with --store-derived or --compress stays so");
    command.add_flag("--store-derived", arguments->file.derived,
                     "Write edge lengths and dihedral angles too, for other programs: three times\n"
                     "the size");
    command.add_flag("--compress", arguments->file.compress,
                     "Compress numbers without loss (shuffle and deflate, which every HDF5 reader\n"
                     "has); slower to write and to read");
    return [arguments](const Session& session) { run(session, *arguments); };
}

} // namespace shape::tools
