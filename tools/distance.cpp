// SPDX-License-Identifier: MIT

#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/stop.h"
#include "libshape/base/to_size.h"
#include "libshape/edge_space/streamed_space.h"
#include "libshape/io/long_table.h"
#include "libshape/model/shape_distances.h"
#include "libshape/model/streamed_distances.h"
#include "libshape/model/streamed_fit.h"
#include "libshape/report/heat_map.h"
#include "libshape/report/score_plot.h"
#include "libshape/statistics/classical_scaling.h"
#include "libshape/statistics/hierarchical_clustering.h"
#include "tools/commands.h"
#include "tools/input/label_input.h"
#include "tools/input/mesh_stream_input.h"
#include "tools/input/space_arguments.h"
#include "tools/output/mesh_table.h"
#include "tools/output/output_rules.h"
#include "tools/output/plot_output.h"
#include "tools/program/arguments.h"
#include "tools/program/ranks.h"
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
    MemoryArgument memory;
};

/// The files that the run writes, by option; those not asked for are left out.
std::vector<std::pair<std::string, std::string>> outputs(const Arguments& arguments)
{
    std::vector<std::pair<std::string, std::string>> files;
    const auto add = [&](const std::string& option, const std::string& path) {
        if (!path.empty())
            files.emplace_back(option, path);
    };
    add("-o", arguments.output);
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
    if (files.empty())
        throw UsageError("-o is required, or another file to write");
    for (std::size_t i = 0; i < files.size(); ++i) {
        const auto& [option, path] = files[i];
        if (option == "--plot" || option == "--heat-map")
            check_picture(option, path);
        if (option == "-o" || option == "--mds")
            check_ending(option, path, ".csv");
        for (std::size_t j = 0; j < i; ++j)
            check_different(option, path, files[j].first, files[j].second);
        check_output(session, path, inputs);
    }
}

/// The columns of the matrix: a mesh may be named `mesh`, which is refused.
std::vector<std::string> matrix_columns(const std::vector<std::string>& names)
{
    Table table{{"mesh"}, {}};
    table.columns.insert(table.columns.end(), names.begin(), names.end());
    check_columns(table);
    return table.columns;
}

/// The mean and the largest of all distances, row by row.
struct Extent
{
    double sum = 0.0;
    double largest = 0.0;

    void add(const Eigen::Ref<const Eigen::RowVectorXd>& row)
    {
        sum += row.sum();
        largest = std::max(largest, row.maxCoeff());
    }
    [[nodiscard]] double mean(std::size_t meshes) const
    {
        return sum / static_cast<double>(meshes * (meshes - 1));
    }
};

/// What is found of the distances.
struct Findings
{
    ShapeSpace space;
    ClassicalScaling scaling;
    Eigen::MatrixXd matrix; ///< Empty where it is not held.
};

std::vector<std::string> row_cells(const std::string& name,
                                   const Eigen::Ref<const Eigen::RowVectorXd>& distances)
{
    std::vector<std::string> cells{name};
    for (const double distance : distances)
        cells.push_back(print_number(distance));
    return cells;
}

Table scaling_table(const MeshLabels& meshes, const ClassicalScaling& scaling)
{
    Table table = mesh_table(meshes.names, meshes.labels);
    for (Eigen::Index k = 0; k < scaling.points.cols(); ++k)
        add_column(table, join("mds", k + 1), scaling.points.col(k));
    check_columns(table);
    return table;
}

std::string draw_scaling(const MeshLabels& meshes, const std::vector<std::string>& values,
                         const ClassicalScaling& scaling, const PointPlotArguments& points)
{
    Plot plot = score_plot(scaling.points, meshes.names, values, {}, score_plot_options(points));
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
Table cluster_table(const MeshLabels& meshes, const Clustering& clustering)
{
    Table table = mesh_table(meshes.names, meshes.labels);
    std::vector<std::vector<std::string>> ordered;
    for (const int mesh : clustering.order)
        ordered.push_back(table.rows[to_size(mesh)]);
    table.rows = std::move(ordered);
    add_column(table, "joins_at", joining_heights(clustering));
    check_columns(table);
    return table;
}

/// Everything but the matrix itself, made before anything is written.
std::vector<std::pair<std::string, std::function<void()>>> further_outputs(
    const Arguments& arguments, const MeshLabels& meshes, const Findings& found)
{
    const std::vector<std::string> values = colouring_values(arguments.points, meshes.labels);
    const bool clusters = !arguments.clusters.empty() || !arguments.heat_map.empty();
    const Clustering clustering =
        clusters ? cluster_by_average_linkage(found.matrix) : Clustering{};
    const Table scaled = scaling_table(meshes, found.scaling);
    const Table clustered = clusters ? cluster_table(meshes, clustering) : Table{};
    std::vector<std::pair<std::string, std::function<void()>>> writers;
    for (const auto& [option, path] : outputs(arguments)) {
        if (option == "--plot")
            writers.emplace_back(
                path, [path = path,
                       picture = draw_scaling(meshes, values, found.scaling, arguments.points)] {
                    write_picture(path, picture);
                });
        else if (option == "--heat-map")
            writers.emplace_back(path,
                                 [path = path, picture = heat_map_svg({.title = {},
                                                                       .names = meshes.names,
                                                                       .label_values = values,
                                                                       .distances = found.matrix,
                                                                       .clustering = clustering})] {
                                     write_picture(path, picture);
                                 });
        else if (option != "-o")
            writers.emplace_back(path,
                                 [path = path, table = option == "--mds" ? scaled : clustered] {
                                     write_table(path, table);
                                 });
    }
    return writers;
}

/// Shows the rows of the matrix in their order, some at a time.
using EachRows =
    std::function<void(const std::function<void(Eigen::Index, const RowMatrix&)>& visit)>;

void write_all(const Session& session, const Arguments& arguments, const MeshLabels& meshes,
               const Findings& found, const EachRows& each_rows)
{
    if (!ranks().is_root()) { // takes part in what is measured
        if (!arguments.output.empty())
            each_rows([](Eigen::Index, const RowMatrix&) { throw_if_stop_requested(); });
        return;
    }
    const auto columns = matrix_columns(meshes.names);
    const auto writers = further_outputs(arguments, meshes, found);
    Extent extent;
    Json written = Json::array();
    if (!arguments.output.empty()) {
        write_long_table(arguments.output, columns, [&](const auto& add) {
            each_rows([&](Eigen::Index first, const RowMatrix& distances) {
                throw_if_stop_requested();
                for (Eigen::Index i = 0; i < distances.rows(); ++i) {
                    extent.add(distances.row(i));
                    add(row_cells(meshes.names[to_size(first + i)], distances.row(i)));
                }
            });
        });
        written.push_back(arguments.output);
    }
    for (const auto& [path, write] : writers) {
        write();
        written.push_back(path);
    }
    const ClassicalScaling& scaling = found.scaling;
    Json figures{{"outputs", written}, {"meshes", meshes.size()}};
    figures.update(space_figures(found.space));
    std::string text =
        join(written.front().get<std::string>(), ": distances between ", meshes.size(), " meshes");
    if (!arguments.output.empty()) {
        figures["mean"] = extent.mean(meshes.size());
        figures["largest"] = extent.largest;
        text += join(", mean ", extent.mean(meshes.size()), ", largest ", extent.largest);
    }
    session.message(text);
    if (!arguments.scaling.empty() || !arguments.plot.empty())
        figures["mds_share"] =
            scaling.total > 0.0 ? scaling.eigenvalues.cwiseMax(0.0).sum() / scaling.total : 1.0;
    session.print_figures(figures);
}

void measure_in_memory(const Session& session, const Arguments& arguments)
{
    const Collection collection = read_labelled(session, arguments.input);
    (void)colouring_values(arguments.points, collection.labels); // refused before the work
    ShapeDistances distances = shape_distances(collection, arguments.space);
    warn_of_alignment(session, distances.space);
    throw_if_stop_requested();
    const Findings found{std::move(distances.space), classical_scaling(distances.matrix, 2),
                         std::move(distances.matrix)};
    write_all(session, arguments, collection, found, [&](const auto& visit) {
        for (Eigen::Index i = 0; i < found.matrix.rows(); ++i)
            visit(i, found.matrix.row(i));
    });
}

/// Trees and heat maps are made of the whole matrix.
void check_matrix(const Arguments& arguments, const MeshStream& meshes)
{
    const std::uint64_t memory =
        arguments.memory.bytes > 0 ? arguments.memory.bytes : usual_memory();
    const std::uint64_t bytes = 3 * sizeof(double) * to_size(meshes.size() * meshes.size());
    if (bytes > memory)
        throw LimitExceeded(join("--cluster and --heat-map need all distances of ", meshes.size(),
                                 " meshes, ", bytes >> 20, " MiB; the memory allowed is ",
                                 memory >> 20, " MiB; allow more (--memory) or leave them out"));
}

void measure_in_passes(const Session& session, const Arguments& arguments, const MeshStream& meshes)
{
    (void)colouring_values(arguments.points, meshes.labels);
    const StreamedDistancesOptions options{.space = arguments.space,
                                           .memory = arguments.memory.bytes,
                                           .progress = session.progress(),
                                           .ranks = ranks()};
    const bool holds = !arguments.clusters.empty() || !arguments.heat_map.empty();
    if (holds)
        check_matrix(arguments, meshes);
    Findings found{make_space(meshes, arguments.space, 8), {}, {}};
    if (!arguments.scaling.empty() || !arguments.plot.empty())
        found.scaling = classical_scaling(meshes, 2, options);
    if (holds) {
        found.matrix.resize(meshes.size(), meshes.size());
        (void)for_each_distance_row(
            meshes, options, [&](Eigen::Index first, const RowMatrix& distances) {
                found.matrix.middleRows(first, distances.rows()) = distances;
            });
    }
    write_all(session, arguments, meshes, found, [&](const auto& visit) {
        if (!holds)
            (void)for_each_distance_row(meshes, options, visit);
        for (Eigen::Index i = 0; i < found.matrix.rows(); ++i)
            visit(i, found.matrix.row(i));
    });
}

void run(const Session& session, const Arguments& arguments)
{
    check(session, arguments);
    if (const auto meshes = open_for_passes(session, arguments.input, arguments.space,
                                            arguments.memory, ranks().partial_sums > 1))
        measure_in_passes(session, arguments, *meshes);
    else
        measure_in_memory(session, arguments);
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
    add_output_file(command, arguments->output,
                    "CSV file to write: mesh, then a column a mesh; may be left out where another\n"
                    "file is written, which of many meshes is far quicker")
        ->required(false)
        ->option_text("FILE");
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
    add_memory(command, arguments->memory);
    return [arguments, chosen](const Session& session) {
        if (*chosen) {
            arguments->space.kind = (*chosen)->kind;
            arguments->space.scale = (*chosen)->scale;
        }
        run(session, *arguments);
    };
}

} // namespace shape::tools
