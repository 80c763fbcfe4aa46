// SPDX-License-Identifier: MIT

#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/edge_space/shape_vectors.h"
#include "tools/commands.h"
#include "tools/common/arguments.h"
#include "tools/common/embedding_run.h"
#include "tools/common/mesh_input.h"
#include "tools/common/mesh_output.h"
#include "tools/common/session.h"

namespace shape::tools {
namespace {

/// How the inputs are joined.
enum class Path
{
    Line, ///< Combinations of the inputs; frames run from the first of two to the second.
};

struct Arguments
{
    MeshInput meshes;
    std::vector<std::string> weights;
    std::int64_t frames = 0;
    Path path = Path::Line;
    LengthBlend lengths = LengthBlend::Plain;
    bool extrapolate = false;
    MeshOutputArguments output;
    EmbeddingArguments embedding;
};

/// @throws InvalidInput if the weights do not fit the meshes: their number, sum (within 1e-9 of 1)
///     or range.
void check_weights(const std::string& text, const Eigen::VectorXd& weights, Eigen::Index meshes,
                   bool extrapolate)
{
    const std::string place = join("--weights ", text, ": ");
    if (weights.size() != meshes)
        throw InvalidInput(join(place, weights.size(), " weights for ", meshes, " meshes"));
    if (std::abs(weights.sum() - 1.0) > 1e-9)
        throw InvalidInput(join(place, "the weights sum to ", weights.sum(), ", not to 1"));
    for (Eigen::Index i = 0; i < weights.size(); ++i)
        if (!extrapolate && (weights[i] < 0.0 || weights[i] > 1.0))
            throw InvalidInput(join(place, "weight ", i + 1, " is ", weights[i],
                                    ", outside [0, 1]; --extrapolate allows it"));
}

/// The weights of every frame, in order.
std::vector<Eigen::VectorXd> frame_weights(const Arguments& arguments, Eigen::Index meshes)
{
    std::vector<Eigen::VectorXd> frames;
    for (const std::string& text : arguments.weights) {
        const std::vector<double> numbers = read_numbers(text, "--weights");
        frames.push_back(Eigen::Map<const Eigen::VectorXd>(
            numbers.data(), static_cast<Eigen::Index>(numbers.size())));
        check_weights(text, frames.back(), meshes, arguments.extrapolate);
    }
    if (arguments.frames > 0 && meshes != 2)
        throw InvalidInput(
            join("--frames: a line has two ends, not ", meshes, " meshes; give --weights"));
    for (std::int64_t i = 0; i < arguments.frames; ++i) {
        const double t = static_cast<double>(i) / static_cast<double>(arguments.frames - 1);
        frames.emplace_back(Eigen::Vector2d(1.0 - t, t));
    }
    return frames;
}

void run(const Session& session, const Arguments& arguments)
{
    const Collection collection = read_meshes(session, arguments.meshes);
    if (collection.size() < 2)
        throw InvalidInput(join("one mesh cannot be blended; give two or more (",
                                collection.names.front(), " is the only one)"));
    const ShapeVectors vectors = encode(collection, Scale::None);
    std::vector<EmbeddingTarget> targets;
    for (const Eigen::VectorXd& weights :
         frame_weights(arguments, static_cast<Eigen::Index>(collection.size())))
        targets.push_back({numbered_name("frame", targets.size()), [&vectors, &arguments, weights] {
                               return blend(vectors, weights, arguments.lengths);
                           }});
    MeshOutput output(session, arguments.output, names(targets), input_files(arguments.meshes));
    session.print_figures(embed_and_write(
        session, arguments.embedding, collection.topology, collection.points, targets, output,
        arguments.frames > 0 ? TargetOrder::Sequence : TargetOrder::Any));
}

} // namespace

Run set_up_interpolate(CLI::App& command)
{
    command.description(
        "Blend two or more meshes in edge-length space. Each blend is written as a mesh\n"
        "(frame_0000.ply, frame_0001.ply, ...), turned and placed as the first mesh is.");
    command.footer(
        "Examples:\n"
        "  shape interpolate a.ply b.ply -o frames/ --frames 11\n"
        "  shape interpolate a.ply b.ply -o animation.glb --frames 50 --fps 25\n"
        "  shape interpolate a.ply b.ply c.ply -o mean.ply --weights 0.25,0.25,0.5");
    const auto arguments = std::make_shared<Arguments>();
    add_mesh_input(command, arguments->meshes);
    add_mesh_output(command, arguments->output);
    add_animation_options(command, arguments->output);
    CLI::Option_group* blends = command.add_option_group("Blends", "exactly one of");
    blends
        ->add_option("--weights", arguments->weights,
                     "One weight a mesh; they sum to 1 (within 1e-9) and lie in [0, 1]. Repeat\n"
                     "the option for several blends")
        ->allow_extra_args(false)
        ->option_text("w1,w2,...");
    add_integer(*blends, "--frames", arguments->frames,
                "N blends of two meshes, equally spaced from the first to the second, both\n"
                "included, [2, 1000000]",
                2, 1'000'000);
    blends->require_option(1);
    add_choice(command, "--path", arguments->path, "line: combinations of the meshes (default)",
               {{"line", Path::Line}});
    add_choice(
        command, "--lengths", arguments->lengths,
        "What is combined: plain lengths (default) or squared lengths (Rojas 2014, section 6)",
        {{"plain", LengthBlend::Plain}, {"squared", LengthBlend::Squared}});
    command.add_flag("--extrapolate", arguments->extrapolate, "Allow weights outside [0, 1]");
    add_embedding_options(command, arguments->embedding);
    return [arguments](const Session& session) { run(session, *arguments); };
}

} // namespace shape::tools
