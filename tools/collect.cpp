// SPDX-License-Identifier: MIT

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <numeric>
#include <set>

#include "libshape/base/counted.h"
#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/to_size.h"
#include "libshape/io/collection_file.h"
#include "libshape/io/collection_stream.h"
#include "libshape/mesh/congruent_meshes.h"
#include "libshape/mesh/edge_lengths.h"
#include "libshape/model/unlike_meshes.h"
#include "tools/commands.h"
#include "tools/input/label_gaps.h"
#include "tools/input/label_input.h"
#include "tools/input/mesh_stream_input.h"
#include "tools/output/output_rules.h"
#include "tools/output/unlike_warnings.h"
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

/// Some of the meshes that are there, the first one among them: as few as say how sizes spread.
Collection samples_of(const MeshStream& present)
{
    const Eigen::Index count = std::min<Eigen::Index>(present.size(), 5);
    std::vector<Eigen::Index> chosen;
    Collection samples{present.topology, {}, {}, {}};
    for (Eigen::Index k = 0; k < count; ++k) {
        chosen.push_back(k * present.size() / count);
        samples.names.push_back(present.names[to_size(chosen.back())]);
    }
    samples.points.resize(to_size(count), Points(present.topology.vertex_count(), 3));
    present.fetch(std::move(chosen))(samples.points);
    return samples;
}

/// Warns of meshes that are added and are unlike those that are there, be they alike among themselves.
void warn_of_unlike_added(const Session& session, const std::string& output,
                          const Collection& samples, const Collection& added)
{
    Eigen::VectorXd sizes(std::ssize(added.points));
    for (std::size_t i = 0; i < added.size(); ++i)
        sizes[static_cast<Eigen::Index>(i)] = edge_lengths(added.topology, added.points[i]).sum();
    warn_of_unlike(
        session, added.names, unlike_meshes(known_meshes(samples), added, sizes),
        {.others = join("the meshes of ", output), .mirrored = "edge lengths do not see that"});
}

/// Warns of meshes that are added and are copies of any that are there.
void warn_of_copies(const Session& session, const MeshStream& present, const Collection& added)
{
    const std::set<std::string> there(present.names.begin(), present.names.end());
    if (std::ranges::any_of(added.names, [&](const auto& name) { return there.contains(name); }))
        return; // which is refused
    const MeshStream some =
        subset(present, meshes_to_compare(present, added.points, session.progress()));
    const std::size_t count = some.names.size();
    Collection together{added.topology, some.names, {}, {}};
    together.names.insert(together.names.end(), added.names.begin(), added.names.end());
    std::vector<Eigen::Index> all(count);
    std::iota(all.begin(), all.end(), 0);
    together.points.resize(count, Points(added.topology.vertex_count(), 3));
    some.fetch(std::move(all))(together.points);
    together.points.insert(together.points.end(), added.points.begin(), added.points.end());
    for (const Copies& copies : congruent_meshes(together.topology, together.points))
        if (copies.meshes.front() < count && copies.meshes.back() >= count)
            session.warn(describe(copies, together.names));
}

/// Warns of a mesh that is added and has the name of one that is there as tables spell it.
void warn_of_names_alike(const Session& session, const std::string& output,
                         const MeshStream& present, const Collection& added)
{
    std::vector<std::string> names = present.names;
    names.insert(names.end(), added.names.begin(), added.names.end());
    std::vector<std::string> places;
    for (std::size_t i = 0; i < names.size(); ++i)
        places.push_back(i < present.names.size() ? join(output, ": mesh ", names[i]) : names[i]);
    if (const auto alike = find_names_alike(names, places);
        alike && alike->second >= present.names.size())
        session.warn(alike->message);
}

/// How meshes that are there get other labels.
std::string way_to_label(const std::string& output)
{
    return join("give them with --labels, or label all anew: `shape collect ", output,
                " --labels FILE -o OTHER.h5`");
}

/// The meshes of the output and those that are added to it: positions that are there are passed on
/// as they are.
void append(const Session& session, const Arguments& arguments)
{
    check_not_protected(arguments.output);
    const MeshStream present = open_collection(arguments.output);
    for (const std::filesystem::path& path : input_files(arguments.input.meshes))
        if (std::filesystem::equivalent(path, arguments.output))
            throw UsageError(join(arguments.output, ": the output is an input of the run"));
    const Collection samples = samples_of(present);
    LabelledInput input = arguments.input; // compared with these, not with each other
    input.meshes.known =
        NamedMesh{samples.names.front(), join(arguments.output, ": mesh ", samples.names.front()),
                  samples.points.front(), samples.topology.faces()};
    const Collection added = read_labelled(session, input);
    LabelGaps gaps;
    gaps.add(present.names, present.labels);
    gaps.add(input.meshes, added);
    warn_of_unlike_added(session, arguments.output, samples, added);
    warn_of_copies(session, present, added);
    warn_of_names_alike(session, arguments.output, present, added);
    const Eigen::Index meshes = append_to_collection(arguments.output, stream_of(added),
                                                     arguments.file, session.progress());
    std::vector<std::string> names = present.names;
    names.insert(names.end(), added.names.begin(), added.names.end());
    gaps.warn(session, names, way_to_label(arguments.output));
    report(session, arguments, added.topology, meshes);
}

void run(const Session& session, const Arguments& arguments)
{
    check_ending("-o", arguments.output, ".h5");
    if (arguments.append)
        return append(session, arguments);
    check_output(session, arguments.output, input_files(arguments.input.meshes));
    if (const auto meshes = open_labelled(session, arguments.input, false)) {
        write_collection(arguments.output, *meshes, arguments.file, session.progress());
        return report(session, arguments, meshes->topology, meshes->size());
    }
    const Collection collection = read_labelled(session, arguments.input);
    LabelGaps gaps;
    gaps.add(arguments.input.meshes, collection);
    gaps.warn(session, collection.names, way_to_label(arguments.output));
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
        "when all is written; its own are copied as they are, and read once before, as the\n"
        "others may be copies of them. What was stored with --store-derived or --compress\n"
        "stays so");
    command.add_flag("--store-derived", arguments->file.derived,
                     "Write edge lengths and dihedral angles too, for other programs: three times\n"
                     "the size");
    command.add_flag("--compress", arguments->file.compress,
                     "Compress numbers without loss (shuffle and deflate, which every HDF5 reader\n"
                     "has); slower to write and to read");
    return [arguments](const Session& session) { run(session, *arguments); };
}

} // namespace shape::tools
