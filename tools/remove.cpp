// SPDX-License-Identifier: MIT

#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/stop.h"
#include "libshape/io/model_file.h"
#include "libshape/model/nuisance.h"
#include "libshape/model/unlike_meshes.h"
#include "tools/commands.h"
#include "tools/input/label_input.h"
#include "tools/input/mesh_choice.h"
#include "tools/input/space_arguments.h"
#include "tools/output/embedding_run.h"
#include "tools/output/unlike_warnings.h"
#include "tools/program/arguments.h"
#include "tools/program/session.h"

namespace shape::tools {
using namespace internal;
namespace {

struct Arguments
{
    LabelledInput input;
    std::int64_t modes = 0;
    std::string model;
    std::string direction;
    std::string like;
    MeshOutputArguments output;
    SpaceOptions space;
    EmbeddingArguments embedding;
};

/// What is removed, and the meshes that it was found of.
struct Found
{
    Nuisance nuisance;
    KnownMeshes known;
    std::string others; ///< "the meshes of m.h5".
};

/// That of a file, if one is named.
std::optional<Found> read_nuisance(const Arguments& arguments)
{
    const int count = static_cast<int>(arguments.modes);
    if (!arguments.direction.empty()) {
        const DifferenceVector difference = read_difference(arguments.direction);
        return Found{direction_of(difference), known_meshes(difference),
                     join("the meshes of ", arguments.direction)};
    }
    if (arguments.model.empty())
        return std::nullopt;
    const ShapeModel model = read_model(arguments.model);
    return Found{leading_modes(model, count), known_meshes(model),
                 join("the meshes of ", arguments.model)};
}

/// The leading modes of the meshes themselves.
Found find_nuisance(const Session& session, const Arguments& arguments,
                    const Collection& collection)
{
    const int count = static_cast<int>(arguments.modes);
    const ShapeModel model = fit_model(collection, {.modes = count, .space = arguments.space});
    warn_of_alignment(session, model.space);
    return {leading_modes(model, count), known_meshes(model), "the meshes of the run"};
}

/// @param mirrored  What comes of mirror images.
void warn_of_unlike(const Session& session, const std::string& option, const Collection& meshes,
                    const Found& found, const std::string& mirrored)
{
    const ShapeSpace& space = found.nuisance.space;
    RowMatrix marks = unlike_meshes(found.known, meshes, sizes(space, meshes));
    if (scale_of(space) == Scale::Unit)
        marks.col(1).setZero(); // sizes are divided out
    tools::warn_of_unlike(session, meshes.names, marks,
                          {.option = option,
                           .others = found.others,
                           .mirrored = mirrored,
                           .size = "Sizes are part of the shape (--scale none): bring all to one "
                                   "unit first"});
}

void run(const Session& session, const Arguments& arguments)
{
    check_space_options(arguments.space);
    std::optional<Found> read = read_nuisance(arguments);
    LabelledInput input = arguments.input;
    const std::string& file =
        arguments.model.empty() ? arguments.direction : arguments.model; // or none
    if (read)
        input.meshes.known =
            NamedMesh{file, file, read->known.reference_points, read->known.topology.faces()};
    const Collection collection = read_labelled(session, input);
    std::vector<std::filesystem::path> inputs = input_files(arguments.input.meshes);
    if (read)
        inputs.emplace_back(file);
    const MeshChoice like{
        "--like", {arguments.like}, arguments.input.meshes.triangulate, notices_of(session).warn};
    if (!arguments.like.empty())
        for (const std::filesystem::path& path : chosen_files(like, collection.names))
            inputs.push_back(path);
    MeshOutput output(session, arguments.output, collection.names, inputs);
    if (read)
        warn_of_unlike(session, "", collection, *read, "angles change the wrong way");
    const Found found = read ? std::move(*read) : find_nuisance(session, arguments, collection);
    const Nuisance& nuisance = found.nuisance;
    throw_if_stop_requested();
    Eigen::VectorXd wanted = Eigen::VectorXd::Zero(nuisance.directions.rows());
    if (!arguments.like.empty()) {
        const Collection target = choose_meshes(
            like, collection,
            {"the run", "the run", collection.points.front(), collection.topology.faces()});
        warn_of_unlike(session, "--like: ", target, found, effect_of_mirroring(nuisance.space));
        wanted = amounts_of(nuisance, target).row(0).transpose();
    }
    const RowMatrix amounts = amounts_of(nuisance, collection);
    std::vector<EmbeddingTarget> targets;
    for (std::size_t i = 0; i < collection.size(); ++i)
        targets.push_back(
            {collection.names[i],
             [&, i] { return with_amounts(nuisance, subset(collection, {i}), wanted); },
             &collection.points[i]});
    Json figures = embed_and_write(session, arguments.embedding, collection.topology,
                                   {collection.points.front()}, targets, output);
    figures.update(space_figures(nuisance.space));
    figures["directions"] = nuisance.directions.rows();
    figures["removed"] = Json::array();
    for (const auto& row : amounts.rowwise())
        figures["removed"].push_back(std::vector<double>(row.begin(), row.end()));
    session.print_figures(figures);
}

} // namespace

Run set_up_remove(CLI::App& command)
{
    command.description(
        "Remove a nuisance from meshes, such as pose, and make them again without it: the leading\n"
        "modes of the meshes themselves or of a model, or the direction of a difference. Each "
        "mesh\n"
        "keeps its own shape otherwise, and its size. Choose exactly one of --modes, --direction.\n"
        "The effect of a number such as age is removed by `shape regress --corrected`.");
    command.footer(
        "Examples:\n"
        "  shape remove walk/ --modes 3 -o standing/\n"
        "  shape remove people/ --model poses.h5 --modes 5 --like person7 -o as_person7/\n"
        "  shape remove faces.h5 --direction smile.h5 -o serious/");
    const auto arguments = std::make_shared<Arguments>();
    add_labelled_input(command, arguments->input);
    CLI::Option_group* what = command.add_option_group("Nuisance", "exactly one of");
    CLI::Option* modes =
        add_integer(*what, "--modes", arguments->modes,
                    "The K leading modes, [1, number of modes], of MESHES or of --model", 1,
                    std::numeric_limits<int>::max());
    CLI::Option* direction =
        what->add_option("--direction", arguments->direction,
                         "The direction of a difference made by `shape difference` (.h5); what is\n"
                         "removed leads to its starting mean")
            ->option_text("FILE");
    what->require_option(1);
    CLI::Option* model = command
                             .add_option("--model", arguments->model,
                                         "Take the modes of this model made by `shape stats` (.h5)")
                             ->option_text("FILE")
                             ->needs(modes);
    command
        .add_option(
            "--like", arguments->like,
            "Instead of the mean, give all meshes as much of the nuisance as this mesh has:\n"
            "the name of one of MESHES, or a mesh file")
        ->option_text("MESH");
    add_mesh_output(command, arguments->output);
    add_space_options(command, arguments->space);
    exclude_space_options(command, *model);
    exclude_space_options(command, *direction);
    add_embedding_options(command, arguments->embedding);
    return [arguments](const Session& session) { run(session, *arguments); };
}

} // namespace shape::tools
