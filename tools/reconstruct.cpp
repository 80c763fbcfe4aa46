// SPDX-License-Identifier: MIT

#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/edge_space/shape_vectors.h"
#include "libshape/io/table_file.h"
#include "tools/commands.h"
#include "tools/input/mesh_input.h"
#include "tools/output/embedding_run.h"
#include "tools/output/mesh_output.h"
#include "tools/program/arguments.h"
#include "tools/program/session.h"

namespace shape::tools {
using namespace internal;
namespace {

struct Arguments
{
    MeshInput references;
    std::string lengths;
    MeshOutputArguments output;
    EmbeddingArguments embedding;
};

int read_vertex(const std::string& cell, const std::string& place, int vertex_count)
{
    const double number = parse_number(cell, place);
    if (number != std::floor(number) || number < 0.0 || number >= vertex_count)
        throw InvalidInput(
            join(place, ": ", cell, " is not a vertex, the reference has 0 to ", vertex_count - 1));
    return static_cast<int>(number);
}

/// #E lengths from a table that names every edge once.
Eigen::VectorXd read_lengths(const std::string& file, const Topology& topology)
{
    const Table table = read_table(file);
    if (table.columns != std::vector<std::string>{"v0", "v1", "length"})
        throw InvalidInput(join(file, ": the columns must be v0,v1,length"));
    Eigen::VectorXd lengths = Eigen::VectorXd::Zero(topology.edge_count());
    for (std::size_t i = 0; i < table.rows.size(); ++i) {
        const std::vector<std::string>& row = table.rows[i];
        const std::string place = join(file, ": row ", i + 1);
        const int a = read_vertex(row[0], place + ", v0", topology.vertex_count());
        const int b = read_vertex(row[1], place + ", v1", topology.vertex_count());
        const int edge = topology.find_edge(a, b);
        if (edge < 0)
            throw InvalidInput(
                join(place, ": the reference has no edge ", a, "-", b, " (vertices count from 0)"));
        if (lengths[edge] > 0.0)
            throw InvalidInput(join(place, ": the edge ", a, "-", b, " occurs twice"));
        lengths[edge] = parse_number(row[2], place + ", length");
        if (lengths[edge] <= 0.0)
            throw InvalidInput(join(place, ": the length ", row[2], " must be > 0"));
    }
    for (int e = 0; e < topology.edge_count(); ++e)
        if (lengths[e] == 0.0)
            throw InvalidInput(join(file, ": the edge ", topology.edges()(e, 0), "-",
                                    topology.edges()(e, 1), " is missing; every edge of the ",
                                    "reference needs a length"));
    return lengths;
}

void run(const Session& session, const Arguments& arguments)
{
    std::vector<std::filesystem::path> inputs = input_files(arguments.references);
    if (!arguments.lengths.empty())
        inputs.emplace_back(arguments.lengths);
    MeshOutput output(session, arguments.output, {"reconstructed"}, inputs);
    const Collection references = read_meshes(session, arguments.references);
    const auto count = static_cast<Eigen::Index>(references.size());
    ShapePoint point = blend(shape_vectors(references, Scale::None),
                             Eigen::VectorXd::Constant(count, 1.0 / static_cast<double>(count)));
    point.patch_turns = {}; // nothing is known of how lengths from elsewhere lie in the large
    if (!arguments.lengths.empty())
        point.edge_lengths = read_lengths(arguments.lengths, references.topology);
    session.print_figures(embed_and_write(session, arguments.embedding, references.topology,
                                          references.points,
                                          {{"reconstructed", [&point] { return point; }}}, output));
}

} // namespace

Run set_up_reconstruct(CLI::App& command)
{
    command.description(
        "Make the mesh of given edge lengths. The triangulation is that of the reference meshes,\n"
        "the dihedral angles start from the mean of theirs.");
    command.footer(
        "Example:\n"
        "  shape reconstruct --reference rest.ply --lengths lengths.csv -o bent.ply");
    const auto arguments = std::make_shared<Arguments>();
    add_mesh_input(command, arguments->references, "--reference");
    command
        .add_option("--lengths", arguments->lengths,
                    "CSV file with the columns v0,v1,length: vertices from 0, in any order, every\n"
                    "edge once, lengths > 0 [unit of the input] (default: the mean lengths of the\n"
                    "references)")
        ->option_text("FILE");
    add_mesh_output(command, arguments->output);
    add_embedding_options(command, arguments->embedding);
    return [arguments](const Session& session) { run(session, *arguments); };
}

} // namespace shape::tools
