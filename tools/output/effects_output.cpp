// SPDX-License-Identifier: MIT

#include "tools/output/effects_output.h"

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "libshape/base/format.h"
#include "libshape/io/table_file.h"
#include "libshape/mesh/vertex_means.h"
#include "tools/output/mesh_output.h"
#include "tools/output/output_rules.h"
#include "tools/program/arguments.h"

namespace shape::tools {
using namespace internal;
namespace {

namespace fs = std::filesystem;

constexpr double significance = 0.05;

fs::path table_path(fs::path path)
{
    return path.replace_extension(".csv");
}

/// One row an edge, in their order.
Table effect_table(const Topology& topology, const ColumnEffects& effects)
{
    Table table{{"v0", "v1", "effect", "p", "q"}, {}};
    for (int e = 0; e < topology.edge_count(); ++e)
        table.rows.push_back({join(topology.edges()(e, 0)), join(topology.edges()(e, 1)),
                              print_number(effects.effects[e]),
                              print_number(effects.probabilities[e]),
                              print_number(effects.false_discovery_rates[e])});
    return table;
}

} // namespace

CLI::Option* add_effects(CLI::App& command, std::string& path)
{
    return command
        .add_option("--effects", path,
                    "Where pairs or groups differ: the mean mesh (.ply, .vtk, .vtp) with the "
                    "values effect\n"
                    "(mean of Cohen's d over the edges at a vertex; > 0: longer), magnitude (of\n"
                    "its absolute value) and significant (share of edges with q <= 0.05), for\n"
                    "`shape draw --color-by`; and FILE.csv with one row an edge: v0,v1,effect,p,q\n"
                    "(t test, paired or, of groups, Welch's; q by Benjamini and Hochberg)")
        ->option_text("FILE.ply");
}

void check_effects(const Session& session, const fs::path& path,
                   const std::vector<fs::path>& inputs)
{
    if (!has_ending(path, ".ply") && !has_ending(path, ".vtk") && !has_ending(path, ".vtp"))
        throw UsageError(join("--effects: '", path.string(),
                              "' must end in .ply, .vtk or .vtp, which hold values at vertices"));
    check_output(session, path, inputs);
    check_output(session, table_path(path), inputs);
}

Json write_effects(const Session& session, const fs::path& path, const Topology& topology,
                   const Points& points, const ColumnEffects& effects,
                   const MeshOutputArguments& form)
{
    const Eigen::VectorXd significant =
        (effects.false_discovery_rates.array() <= significance).cast<double>();
    const Eigen::VectorXd magnitudes = effects.effects.cwiseAbs();
    write_table(table_path(path), effect_table(topology, effects));
    write_with_colours(path, points, topology.faces(),
                       {{"effect", vertex_means(topology, effects.effects)},
                        {"magnitude", vertex_means(topology, magnitudes)},
                        {"significant", vertex_means(topology, significant)}},
                       form.colours,
                       {.ascii = form.ascii, .single_precision = form.single_precision});
    const auto count = static_cast<int>(significant.sum());
    session.message(join(path.string(), ": ", count, " of ", topology.edge_count(),
                         " edges differ (q <= ", significance, "); largest effect ",
                         magnitudes.maxCoeff()));
    return {{"outputs", {path.string(), table_path(path).string()}},
            {"edges", topology.edge_count()},
            {"significant_edges", count},
            {"largest_effect", magnitudes.maxCoeff()}};
}

} // namespace shape::tools
