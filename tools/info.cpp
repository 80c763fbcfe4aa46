// SPDX-License-Identifier: MIT

#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>

#include "libshape/base/format.h"
#include "libshape/base/to_size.h"
#include "libshape/io/collection_file.h"
#include "libshape/io/model_file.h"
#include "libshape/mesh/edge_lengths.h"
#include "tools/commands.h"
#include "tools/input/space_arguments.h"
#include "tools/output/model_tables.h"
#include "tools/program/session.h"

namespace shape::tools {
using namespace internal;
namespace {

/// What is to be said of one file: figures, and a table for people if there is one.
struct Description
{
    Json figures;
    std::string table;
};

Json topology_figures(const Topology& topology)
{
    return {{"vertices", topology.vertex_count()},
            {"edges", topology.edge_count()},
            {"faces", topology.face_count()},
            {"boundary_loops", topology.boundary_loop_count()},
            {"genus", topology.genus()}};
}

Description describe_collection(const std::string& file)
{
    const Collection collection = read_collection(file);
    Eigen::VectorXd sizes(static_cast<Eigen::Index>(collection.size()));
    for (Eigen::Index i = 0; i < sizes.size(); ++i)
        sizes[i] = edge_lengths(collection.topology, collection.points[to_size(i)]).sum();
    Json figures{{"kind", "collection"}, {"meshes", collection.size()}};
    figures.update(topology_figures(collection.topology));
    figures["smallest_size"] = sizes.minCoeff();
    figures["mean_size"] = sizes.mean();
    figures["largest_size"] = sizes.maxCoeff();
    figures["labels"] = label_figures(collection.labels);
    figures["names"] = collection.names;
    return {figures, {}};
}

Description describe_model(const std::string& file)
{
    const ShapeModel model = read_model(file);
    Json figures{{"kind", "model"}, {"meshes", model.names.size()}};
    figures.update(topology_figures(model.topology));
    figures.update(space_figures(model.space));
    figures["mean_size"] = model.mean_size();
    figures["total_variance"] = model.total_variance;
    figures["labels"] = label_figures(model.labels);
    figures["modes"] = mode_figures(model);
    return {figures, mode_table(mode_figures(model))};
}

Description describe_difference(const std::string& file)
{
    const DifferenceVector difference = read_difference(file);
    Json figures{{"kind", "difference"}, {"pairs", difference.pairs.size()}};
    figures.update(topology_figures(difference.topology));
    figures["scale"] = name(difference.scale);
    figures["norm"] = difference.edge_lengths.norm();
    figures["from_size"] = difference.from_size;
    figures["to_size"] = difference.to_size;
    return {figures, {}};
}

Description describe(const std::string& file)
{
    switch (file_kind(file)) {
        case FileKind::Collection:
            return describe_collection(file);
        case FileKind::Model:
            return describe_model(file);
        case FileKind::Difference:
            return describe_difference(file);
    }
    return {};
}

void run(const Session& session, const std::string& file)
{
    const Description description = describe(file);
    Json figures{{"file", session.readable(file)}};
    figures.update(description.figures);
    if (session.json)
        return session.print_figures(figures);
    std::string text;
    for (const auto& [key, value] : figures.items()) {
        if (key == "modes" || key == "names")
            continue; // one is the table below, the other may be long
        text += join(key, ": ", value.is_string() ? value.get<std::string>() : value.dump(), "\n");
    }
    session.print(text + description.table);
}

} // namespace

Run set_up_info(CLI::App& command)
{
    command.description(
        "Say what is in a collection, a model or a difference. For a model: the variance of every\n"
        "mode, its share, the cumulative share, and how far one can go along it from the mean (up\n"
        "to 10 standard deviations) before a triangle inequality breaks. Sizes are sums of edge\n"
        "lengths, in models of Procrustes space centroid sizes, in the unit of the input.");
    command.footer("Example:\n  shape info model.h5");
    const auto file = std::make_shared<std::string>();
    command.add_option("FILE", *file, "Collection, model or difference (.h5)")
        ->required()
        ->option_text("REQUIRED");
    return [file](const Session& session) { run(session, *file); };
}

} // namespace shape::tools
