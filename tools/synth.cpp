// SPDX-License-Identifier: MIT

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "libshape/base/clean_up.h"
#include "libshape/base/counted.h"
#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/io/mesh_file.h"
#include "libshape/io/table_file.h"
#include "libshape/registration/synthetic_scan.h"
#include "libshape/synthetic/synthetic.h"
#include "tools/commands.h"
#include "tools/input/mesh_input.h"
#include "tools/output/mesh_output.h"
#include "tools/output/mesh_table.h"
#include "tools/output/output_rules.h"
#include "tools/program/arguments.h"
#include "tools/program/session.h"

namespace shape::tools {
using namespace internal;
namespace {

namespace fs = std::filesystem;

struct Arguments
{
    bool list = false;
    std::string name;
    std::int64_t count = 0;
    std::int64_t vertices = 0;
    MeshOutputArguments output;
    MeshInput of; ///< What scans are made of; none: the faces.
    SyntheticScanOptions scan;
    std::int64_t holes = 0;
};

constexpr const char* scans_name = "scans";

Json figures(const SyntheticRange& range)
{
    return {{"default", range.standard}, {"low", range.low}, {"high", range.high}};
}

std::string print(const SyntheticRange& range)
{
    return join(range.standard, " [", range.low, ", ", range.high, "]");
}

/// `scans` is not a dataset of the library.
void check_name(const std::string& name)
{
    std::string names;
    for (const SyntheticDataset& set : synthetic_datasets()) {
        if (set.name == name)
            return;
        names += set.name + ", ";
    }
    throw InvalidInput(join("no synthetic dataset '", name, "'; there are ", names, scans_name));
}

void list_datasets(const Session& session)
{
    Json datasets = Json::array();
    std::string text;
    for (const SyntheticDataset& set : synthetic_datasets()) {
        datasets.push_back({{"name", set.name},
                            {"description", set.description},
                            {"count_meaning", set.count_meaning},
                            {"count", figures(set.count)},
                            {"vertices", figures(set.vertices)}});
        text += join(set.name, ": ", set.description, "\n  --count ", print(set.count), ": ",
                     set.count_meaning, "\n  --vertices ", print(set.vertices), "\n");
    }
    text += join(scans_name,
                 ": raw scans of other triangulations of the faces, or of --of MESHES, with "
                 "the truth and landmarks\n");
    if (!session.json)
        session.print(text);
    session.print_figures({{"datasets", datasets}});
}

/// The landmarks of the template and of every scan, by the template's vertices.
Table landmark_table(const Collection& truth)
{
    constexpr int landmark_count = 8; // as in Rojas 2014, section 4
    const std::vector<int> vertices =
        spread_vertices(truth.topology, truth.points.front(),
                        std::min(landmark_count, truth.topology.vertex_count()));
    Table table{{"scan", "name", "x", "y", "z"}, {}};
    const auto add = [&](const std::string& scan, const Points& points) {
        for (std::size_t i = 0; i < vertices.size(); ++i) {
            const auto place = points.row(vertices[i]);
            table.rows.push_back({scan, join("landmark", i + 1), print_number(place[0]),
                                  print_number(place[1]), print_number(place[2])});
        }
    };
    add("template", truth.points.front());
    for (std::size_t i = 0; i < truth.size(); ++i)
        add(truth.names[i], truth.points[i]);
    return table;
}

/// The directory of a run, made with its parents where they are missing. What was made goes again if the run
/// ends before anything is in it.
class RunDirectory
{
public:
    explicit RunDirectory(const fs::path& path)
    {
        for (fs::path part = path; !part.empty() && !fs::exists(part); part = part.parent_path())
            if (part.has_filename())
                made_.push_back(part);
        std::error_code error;
        fs::create_directories(path, error);
        if (error)
            throw FileError(join(path.string(), ": ", error.message()));
    }
    ~RunDirectory()
    {
        clean_up([&] {
            std::error_code ignored; // what is not empty stays
            for (const fs::path& part : made_)
                fs::remove(part, ignored);
        });
    }
    RunDirectory(const RunDirectory&) = delete;
    RunDirectory& operator=(const RunDirectory&) = delete;

private:
    std::vector<fs::path> made_; ///< From the innermost out.
};

void make_scans(const Session& session, const Arguments& arguments)
{
    const bool is_given = !arguments.of.paths.empty();
    if (is_given && arguments.count > 0)
        throw UsageError(
            "--count is for shapes that are made up; with --of, all its meshes are scanned");
    const Collection truth =
        is_given ? read_meshes(session, arguments.of)
                 : make_synthetic("faces", {.count = static_cast<int>(arguments.count),
                                            .seed = static_cast<std::uint64_t>(session.seed)});
    const fs::path directory = arguments.output.path;
    const auto output_in = [&](const char* folder) {
        MeshOutputArguments output = arguments.output;
        output.path = (directory / folder / "").string();
        return output;
    };
    const std::vector<fs::path> inputs =
        is_given ? input_files(arguments.of) : std::vector<fs::path>{};
    const fs::path pattern = directory / "template.ply", landmarks = directory / "landmarks.csv",
                   labels = directory / "labels.csv";
    const RunDirectory made(directory);
    for (const fs::path& path : {pattern, landmarks, labels})
        check_output(session, path, inputs);
    MeshOutput scans(session, output_in("scans"), truth.names, inputs);
    MeshOutput meshes(session, output_in("truth"), truth.names, inputs);
    SyntheticScanOptions options = arguments.scan;
    options.vertices = static_cast<int>(arguments.vertices);
    options.holes = static_cast<int>(arguments.holes);
    const Progress progress = session.progress();
    for (std::size_t i = 0; i < truth.size(); ++i) {
        if (progress)
            progress("scanning", i, truth.size());
        options.seed = static_cast<std::uint64_t>(session.seed) + i;
        const Scan scan = synthetic_scan(truth.topology, truth.points[i], options);
        scans.write(i, scan.points, scan.faces);
        meshes.write(i, truth.points[i], truth.topology.faces());
    }
    if (progress)
        progress("scanning", truth.size(), truth.size());
    scans.commit();
    meshes.commit();
    write_mesh(pattern, truth.points.front(), truth.topology.faces());
    write_table(landmarks, landmark_table(truth));
    write_table(labels, mesh_table(truth.names, truth.labels));
    session.message(join(directory.string(), ": ", counted(truth.size(), "scan"),
                         " in scans/, what they are scans of in truth/"));
    session.print_figures({{"outputs", {directory.string()}}, {"scans", truth.size()}});
}

void run(const Session& session, const Arguments& arguments)
{
    if (arguments.list)
        return list_datasets(session);
    if (arguments.name.empty() || arguments.output.path.empty())
        throw UsageError("synth needs NAME and -o, or --list; see `shape synth --help`");
    if (arguments.name == scans_name)
        return make_scans(session, arguments);
    if (!arguments.of.paths.empty() || arguments.scan.noise > 0.0 || arguments.holes > 0 ||
        arguments.scan.cut > 0.0)
        throw UsageError("--of, --noise, --holes and --cut are for `shape synth scans`");
    check_name(arguments.name);
    const Progress progress = session.progress();
    const Collection collection =
        make_synthetic(arguments.name, {.count = static_cast<int>(arguments.count),
                                        .vertices = static_cast<int>(arguments.vertices),
                                        .seed = static_cast<std::uint64_t>(session.seed)});
    const std::string label_file = "labels.csv";
    MeshOutput output(session, arguments.output, collection.names, {}, {label_file});
    for (std::size_t i = 0; i < collection.size(); ++i) {
        progress("writing", i, collection.size());
        output.write(i, collection.points[i], collection.topology.faces());
    }
    progress("writing", collection.size(), collection.size());
    write_table(output.staged(label_file), mesh_table(collection.names, collection.labels));
    output.commit();
    session.message(join(arguments.output.path, ": ", counted(collection.size(), "mesh", "meshes"),
                         " of ", collection.topology.vertex_count(), " vertices"));
    session.print_figures({{"outputs", output.paths()},
                           {"meshes", collection.size()},
                           {"vertices", collection.topology.vertex_count()},
                           {"edges", collection.topology.edge_count()},
                           {"faces", collection.topology.face_count()}});
}

} // namespace

Run set_up_synth(CLI::App& command)
{
    command.description(
        "Make a synthetic dataset of the papers from nothing but a seed: a directory of meshes in\n"
        "correspondence with their labels in labels.csv. --list names the sets with their\n"
        "defaults and ranges. `scans` makes raw scans of meshes instead: scans/ of other\n"
        "triangulations, what they are scans of in truth/, template.ply, landmarks.csv and\n"
        "labels.csv.");
    command.footer(
        "Example:\n  shape synth torus -o torus/\n"
        "  shape synth scans --noise 0.15 --holes 4 -o raw/");
    const auto arguments = std::make_shared<Arguments>();
    command.add_option("NAME", arguments->name, "Name of the dataset; see --list");
    CLI::Option* list = command.add_flag("--list", arguments->list, "List the datasets");
    add_mesh_output(command, arguments->output)
        ->required(false)
        ->option_text("DIRECTORY")
        ->excludes(list);
    add_integer(command, "--count", arguments->count,
                "How many, see --list for what is counted (default: that of the dataset)", 1,
                std::numeric_limits<int>::max());
    add_integer(command, "--vertices", arguments->vertices,
                "Wanted vertices of each mesh; what comes out is as near as the construction\n"
                "allows (default: that of the dataset)",
                1, std::numeric_limits<int>::max());
    command
        .add_option("--of", arguments->of.paths,
                    "scans: meshes in correspondence to make scans of (default: the faces)")
        ->option_text("MESHES ...");
    add_number(command, "--noise", arguments->scan.noise,
               "scans: standard deviation of the noise [edges of the scan] (default: 0)");
    add_integer(command, "--holes", arguments->holes, "scans: holes in each (default: 0)", 0, 1000);
    add_number(command, "--cut", arguments->scan.cut,
               "scans: share of the vertices beyond a plane, in [0, 0.9], that is cut off\n"
               "(default: 0)");
    return [arguments](const Session& session) { run(session, *arguments); };
}

} // namespace shape::tools
