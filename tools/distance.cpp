// SPDX-License-Identifier: MIT

#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/to_size.h"
#include "libshape/io/file/output_file.h"
#include "libshape/model/shape_distances.h"
#include "libshape/report/heat_map.h"
#include "libshape/report/score_plot.h"
#include "libshape/statistics/classical_scaling.h"
#include "libshape/statistics/hierarchical_clustering.h"
#include "tools/commands.h"
#include "tools/input/label_input.h"
#include "tools/input/space_arguments.h"
#include "tools/output/mesh_table.h"
#include "tools/output/output_rules.h"
#include "tools/output/plot_output.h"
#include "tools/program/arguments.h"
#include "tools/program/interrupt.h"
#include "tools/program/session.h"

namespace shape::tools {
using namespace internal;
namespace {

struct Arguments
{
    LabelledInput input;
    SpaceOptions space = {};
    std::string output;
    std::string scaling;
    std::string plot;
    std::string clusters;
    std::string heat_map;
    PointPlotArguments points;
};

/// The files that the run writes, by option; those not asked for are left out.
std::vector<std::pair<std::string, std::string>> outputs(const Arguments& arguments)
{
    std::vector<std::pair<std::string, std::string>> files{{"-o", arguments.output}};
    const auto add = [&](const std::string& option, const std::string& path) {
        if (!path.empty())
            files.emplace_back(option, path);
    };
    add("--mds", arguments.scaling);
    add("--plot", arguments.plot);
    add("--cluster", arguments.clusters);
    add("--heat-map", arguments.heat_map);
    return files;
}

void check(const Session& session, const Arguments& arguments)
{
    check_space_options(arguments.space);
    const std::vector<std::filesystem::path> inputs = input_files(arguments.input.meshes);
    const auto files = outputs(arguments);
    for (std::size_t i = 0; i < files.size(); ++i) {
        const auto& [option, path] = files[i];
        if (option == "--plot" || option == "--heat-map")
            check_picture(option, path);
        for (std::size_t j = 0; j < i; ++j)
            check_different(option, path, files[j].first, files[j].second);
        check_output(session, path, inputs);
    }
}

/// The matrix, its rows and columns named.
Table matrix_table(const Collection& collection, const Eigen::MatrixXd& distances)
{
    Table table = mesh_table(collection.names, {});
    for (Eigen::Index i = 0; i < distances.cols(); ++i)
        add_column(table, collection.names[to_size(i)], distances.col(i));
    check_columns(table); // a mesh may be named `mesh`
    return table;
}

Table scaling_table(const Collection& collection, const ClassicalScaling& scaling)
{
    Table table = mesh_table(collection.names, collection.labels);
    for (Eigen::Index k = 0; k < scaling.points.cols(); ++k)
        add_column(table, join("mds", k + 1), scaling.points.col(k));
    check_columns(table);
    return table;
}

std::string draw_scaling(const Collection& collection, const std::vector<std::string>& values,
                         const ClassicalScaling& scaling, const PointPlotArguments& points)
{
    Plot plot =
        score_plot(scaling.points, collection.names, values, {}, score_plot_options(points));
    const auto axis = [&](Eigen::Index k) {
        const double share = // of equal meshes there is nothing to share
            scaling.total > 0.0 ? std::max(scaling.eigenvalues[k], 0.0) / scaling.total : 0.0;
        return join("coordinate ", k + 1, " (", std::round(1000.0 * share) / 10.0,
                    " % of squared distances)");
    };
    plot.x_label = axis(0);
    plot.y_label = axis(1);
    plot.equal_axes = true;
    return plot_svg(plot);
}

/// The meshes in the order of the tree, each with the height at which it joins the one before.
Table cluster_table(const Collection& collection, const Clustering& clustering)
{
    Table table = mesh_table(collection.names, collection.labels);
    std::vector<std::vector<std::string>> ordered;
    for (const int mesh : clustering.order)
        ordered.push_back(table.rows[to_size(mesh)]);
    table.rows = std::move(ordered);
    add_column(table, "joins_at", joining_heights(clustering));
    check_columns(table);
    return table;
}

void run(const Session& session, const Arguments& arguments)
{
    check(session, arguments);
    const Collection collection = read_labelled(session, arguments.input);
    const std::vector<std::string> values = colouring_values(arguments.points, collection.labels);
    const ShapeDistances distances = shape_distances(collection, arguments.space);
    warn_of_alignment(session, distances.space);
    throw_if_interrupted();

    // Everything is made before anything is written.
    const Table matrix = matrix_table(collection, distances.matrix);
    const ClassicalScaling scaling = classical_scaling(distances.matrix, 2);
    const Clustering clustering = cluster_by_average_linkage(distances.matrix);
    const Table scaled = scaling_table(collection, scaling);
    const Table clustered = cluster_table(collection, clustering);
    Json written = Json::array();
    for (const auto& [option, path] : outputs(arguments)) {
        if (option == "--plot")
            write_picture(path, draw_scaling(collection, values, scaling, arguments.points));
        else if (option == "--heat-map")
            write_picture(path, heat_map_svg({.title = {},
                                              .names = collection.names,
                                              .label_values = values,
                                              .distances = distances.matrix,
                                              .clustering = clustering}));
        else
            write_table(path, option == "-o" ? matrix : option == "--mds" ? scaled : clustered);
        written.push_back(path);
    }
    const double pairs = 0.5 * static_cast<double>(collection.size() * (collection.size() - 1));
    const double mean = 0.5 * distances.matrix.sum() / pairs;
    session.message(join(arguments.output, ": distances between ", collection.size(),
                         " meshes, mean ", mean, ", largest ", distances.matrix.maxCoeff()));
    Json figures{{"outputs", written}, {"meshes", collection.size()}};
    figures.update(space_figures(distances.space));
    figures["mean"] = mean;
    figures["largest"] = distances.matrix.maxCoeff();
    figures["mds_share"] =
        scaling.total > 0.0 ? scaling.eigenvalues.cwiseMax(0.0).sum() / scaling.total : 1.0;
    session.print_figures(figures);
}

} // namespace

Run set_up_distance(CLI::App& command)
{
    command.description(
        "Measure the distances between all meshes, as a matrix whose rows and columns carry their\n"
        "names. In edge space a distance is Euclidean between the coordinates, in the unit of the\n"
        "input or, for unit scale, without one; in Procrustes space it is the root of the mean\n"
        "squared distance of corresponding vertices [unit of the input] after generalised\n"
        "alignment, for unit scale with every mesh at the mean centroid size. Draws the meshes on\n"
        "a plane (classical scaling) and orders them by a tree (average linkage).");
    command.footer(
        "Examples:\n"
        "  shape distance faces.h5 -o distances.csv --metric procrustes\n"
        "  shape distance faces.h5 -o d.csv --plot mds.svg --heat-map map.svg --color-by mood");
    const auto arguments = std::make_shared<Arguments>();
    add_labelled_input(command, arguments->input);
    add_output_file(command, arguments->output, "CSV file to write: mesh, then a column a mesh");
    const SpaceOptions edge{.kind = SpaceKind::Edge, .scale = Scale::None};
    const SpaceOptions unit{.kind = SpaceKind::Edge, .scale = Scale::Unit};
    const SpaceOptions procrustes{.kind = SpaceKind::Procrustes, .scale = Scale::Unit};
    const auto chosen = std::make_shared<std::optional<SpaceOptions>>();
    CLI::Option* metric =
        add_choice(command, "--metric", *chosen,
                   "Short for a space and a scale. edge: edge lengths as they are; edge-unit:\n"
                   "divided by their sum (default); procrustes: aligned positions, unit scale",
                   {{"edge", edge}, {"edge-unit", unit}, {"procrustes", procrustes}});
    CLI::Option* space = add_space_options(command, arguments->space);
    metric->excludes(space);
    metric->excludes(command.get_option("--scale"));
    const auto add_file = [&](const char* name, std::string& path, const char* description) {
        return command.add_option(name, path, description)->option_text("FILE");
    };
    add_file("--mds", arguments->scaling,
             "Points of the plane whose distances are nearest in the sense of classical scaling\n"
             "(CSV: mesh, labels, mds1, mds2)");
    CLI::Option* plot =
        add_file("--plot", arguments->plot, "Draw those points, one a mesh (.svg or .png)");
    add_file("--cluster", arguments->clusters,
             "The meshes in the order of the tree (CSV: mesh, labels, joins_at: the height at\n"
             "which a mesh is in one cluster with the one before)");
    add_file("--heat-map", arguments->heat_map,
             "Draw the matrix in the order of the tree, and the tree (.svg or .png)");
    command
        .add_option("--color-by", arguments->points.color_by,
                    "Label whose values get a colour each in the drawings; in the plot, numbers\n"
                    "get a scale and of more than 12 values the smallest share grey")
        ->option_text("LABEL");
    add_point_plot(command, arguments->points, plot);
    return [arguments, chosen](const Session& session) {
        if (*chosen) {
            arguments->space.kind = (*chosen)->kind;
            arguments->space.scale = (*chosen)->scale;
        }
        run(session, *arguments);
    };
}

} // namespace shape::tools
