// SPDX-License-Identifier: MIT

#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>

#include "libshape/base/counted.h"
#include "libshape/base/format.h"
#include "libshape/synthetic/synthetic.h"
#include "tools/commands.h"
#include "tools/output/mesh_output.h"
#include "tools/output/mesh_table.h"
#include "tools/output/output_rules.h"
#include "tools/program/arguments.h"
#include "tools/program/session.h"

namespace shape::tools {
using namespace internal;
namespace {

struct Arguments
{
    bool list = false;
    std::string name;
    std::int64_t count = 0;
    std::int64_t vertices = 0;
    MeshOutputArguments output;
};

Json figures(const SyntheticRange& range)
{
    return {{"default", range.standard}, {"low", range.low}, {"high", range.high}};
}

std::string print(const SyntheticRange& range)
{
    return join(range.standard, " [", range.low, ", ", range.high, "]");
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
    if (!session.json)
        session.print(text);
    session.print_figures({{"datasets", datasets}});
}

void run(const Session& session, const Arguments& arguments)
{
    if (arguments.list)
        return list_datasets(session);
    if (arguments.name.empty() || arguments.output.path.empty())
        throw UsageError("synth needs NAME and -o, or --list; see `shape synth --help`");
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
        "defaults and ranges.");
    command.footer("Example:\n  shape synth torus -o torus/");
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
    return [arguments](const Session& session) { run(session, *arguments); };
}

} // namespace shape::tools
