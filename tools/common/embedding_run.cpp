// SPDX-License-Identifier: MIT

#include "tools/common/embedding_run.h"

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <utility>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/edge_space/admissibility.h"
#include "tools/common/arguments.h"

namespace shape::tools {
namespace {

const char* method_name(EmbeddingMethod method)
{
    switch (method) {
        case EmbeddingMethod::Dihedral:
            return "dihedral";
        case EmbeddingMethod::Closure:
            return "closure";
        case EmbeddingMethod::Multiscale:
            return "multiscale";
    }
    return "";
}

Json figures_of(const std::string& mesh, const std::string& method, const Embedding& embedding)
{
    const EmbeddingReport& report = embedding.report;
    return {{"name", mesh},
            {"method", method},
            {"vertices", embedding.points.rows()},
            {"status", name(report.status)},
            {"edge_rms", report.edge_rms},
            {"edge_max", report.edge_max},
            {"edge_p999", report.edge_p999},
            {"edge_p99", report.edge_p99},
            {"dihedral_rms_deg", report.dihedral_rms_deg},
            {"dihedral_p99_deg", report.dihedral_p99_deg},
            {"dihedral_max_deg", report.dihedral_max_deg},
            {"closure_energy", report.closure_energy},
            {"iterations", report.iterations},
            {"converged", report.converged},
            {"seconds", report.seconds},
            {"setup_seconds", report.setup_seconds}};
}

template <class... Values>
std::string print_row(const char* format, Values... values)
{
    char row[256];
    std::snprintf(row, sizeof row, format, values...);
    return row;
}

std::string table_head()
{
    return print_row("%-24s %-12s %10s %10s %12s %9s", "mesh", "status", "edge RMS", "edge max",
                     "dihedral RMS", "time");
}

std::string table_row(const Json& figures)
{
    const auto number = [&](const char* field) { return figures.at(field).get<double>(); };
    const auto text = [&](const char* field) { return figures.at(field).get<std::string>(); };
    return print_row("%-24s %-12s %9.4f%% %9.4f%% %8.3f deg %7.3f s", text("name").c_str(),
                     text("status").c_str(), 100.0 * number("edge_rms"), 100.0 * number("edge_max"),
                     number("dihedral_rms_deg"), number("seconds"));
}

} // namespace

void add_embedding_options(CLI::App& command, EmbeddingArguments& arguments)
{
    EmbeddingOptions& options = arguments.options;
    add_choice(command, "--method", options.method,
               "dihedral: lengths and dihedral angles together (default); closure: as in Rojas\n"
               "2014, section 2; multiscale: as in Winkler 2010, section 3",
               {{"dihedral", EmbeddingMethod::Dihedral},
                {"closure", EmbeddingMethod::Closure},
                {"multiscale", EmbeddingMethod::Multiscale}})
        ->group("Embedding");
    add_choice(command, "--quality", options.quality,
               "Effort of the method dihedral: preview takes a few steps, fine (default) runs to\n"
               "convergence",
               {{"preview", EmbeddingQuality::Preview}, {"fine", EmbeddingQuality::Fine}})
        ->group("Embedding");
    add_number(command, "--smoothness", options.smoothness,
               join("Weight of the dihedral angles [rad] against the relative lengths, > 0\n"
                    "(default: ",
                    options.smoothness, "); of the method dihedral"),
               Sign::Positive)
        ->group("Embedding");
    command
        .add_flag("--strict", arguments.strict,
                  "An infeasible target ends the run with exit code 4 before anything is\n"
                  "written (default: the nearest mesh is written, with a warning)")
        ->group("Embedding");
}

Json embed_and_write(const Session& session, const EmbeddingArguments& arguments,
                     const Topology& topology, std::vector<Points> references,
                     const std::vector<EmbeddingTarget>& targets, MeshOutput& output)
{
    if (arguments.strict)
        refuse_infeasible(topology, targets);
    const Embedder embedder(topology, std::move(references), arguments.options);
    const auto make = [&](std::size_t i, const ShapePoint& point) {
        return finish(targets[i].name, method_name(arguments.options.method),
                      [&] { return embedder.embed(point); });
    };
    return make_and_write(session, topology, targets, make, output);
}

Json make_and_write(const Session& session, const Topology& topology,
                    const std::vector<EmbeddingTarget>& targets, const MeshMaker& make,
                    MeshOutput& output)
{
    const Progress progress = session.progress();
    Json embeddings = Json::array();
    std::vector<std::string> rows{table_head()};
    for (std::size_t i = 0; i < targets.size(); ++i) {
        progress("embedding", i, targets.size());
        const FinishedMesh mesh = make(i, targets[i].point());
        if (!mesh.reason.empty())
            session.warn(join(targets[i].name, ": infeasible target, ", mesh.reason,
                              "; the nearest mesh is written"));
        output.write(i, mesh.points, topology.faces());
        embeddings.push_back(mesh.figures);
        rows.push_back(table_row(mesh.figures));
    }
    progress("embedding", targets.size(), targets.size());
    output.commit();
    for (const std::string& row : rows)
        session.message(row);
    return {{"outputs", output.paths()}, {"embeddings", embeddings}};
}

void refuse_infeasible(const Topology& topology, const std::vector<EmbeddingTarget>& targets)
{
    for (const EmbeddingTarget& target : targets) {
        const ShapePoint point = target.point();
        const Admissibility found = check_admissibility(topology, point.edge_lengths);
        if (!found.admissible())
            throw NumericalError(join(target.name, ": infeasible target, ",
                                      describe(found, topology, point.edge_lengths),
                                      " (--strict)"));
    }
}

FinishedMesh finish(const std::string& target, const std::string& method,
                    const std::function<Embedding()>& embed)
{
    try {
        Embedding embedding = embed();
        Json figures = figures_of(target, method, embedding);
        return {std::move(embedding.points), std::move(figures),
                std::move(embedding.report.reason)};
    } catch (const InvalidInput& error) {
        throw InvalidInput(join(target, ": ", error.what()));
    } catch (const NumericalError& error) {
        throw NumericalError(join(target, ": ", error.what()));
    }
}

std::string numbered_name(const std::string& stem, std::size_t number)
{
    return print_row("%s_%04zu", stem.c_str(), number);
}

std::vector<std::string> names(const std::vector<EmbeddingTarget>& targets)
{
    std::vector<std::string> result;
    for (const EmbeddingTarget& target : targets)
        result.push_back(target.name);
    return result;
}

} // namespace shape::tools
