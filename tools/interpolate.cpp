// SPDX-License-Identifier: MIT

#include <CLI/CLI.hpp>
#include <cmath>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/to_size.h"
#include "libshape/edge_space/safe_range.h"
#include "libshape/edge_space/shape_vectors.h"
#include "tools/commands.h"
#include "tools/input/mesh_input.h"
#include "tools/input/path_arguments.h"
#include "tools/input/tagged_part.h"
#include "tools/output/embedding_run.h"
#include "tools/output/embedding_settings.h"
#include "tools/output/frame_store.h"
#include "tools/output/mesh_output.h"
#include "tools/output/sequence_run.h"
#include "tools/output/shard.h"
#include "tools/program/arguments.h"
#include "tools/program/session.h"

namespace shape::tools {
using namespace internal;
namespace {

struct Arguments
{
    MeshInput meshes;
    PathArguments path;
    LengthBlend lengths = LengthBlend::Plain;
    TaggedPartArguments part;
    SequenceArguments sequence;
    Shard shard;
    MeshOutputArguments output;
    EmbeddingArguments embedding;
};

/// A number for JSON, which has no infinity.
Json finite_or_null(double value)
{
    return std::isfinite(value) ? Json(value) : Json();
}

/// How far the line through the first two and the last two meshes may be followed: the parameter
/// below 0 and above 1 where the first triangle inequality breaks.
struct SafeRange
{
    SafeReach low;
    SafeReach high;
};

SafeRange safe_range_of_line(const Topology& topology, const ShapeVectors& vectors,
                             LengthBlend lengths)
{
    const Eigen::Index count = vectors.edge_lengths.rows();
    const auto parameter = [&](Eigen::Index end, Eigen::Index inner, double from, double sign) {
        const Eigen::VectorXd start = Eigen::VectorXd::Unit(count, end);
        SafeReach reach = safe_reach(topology, vectors, start,
                                     start - Eigen::VectorXd::Unit(count, inner), lengths);
        reach.reach = from + sign * reach.reach / static_cast<double>(count - 1);
        return reach;
    };
    return {parameter(0, 1, 0.0, -1.0), parameter(count - 1, count - 2, 1.0, 1.0)};
}

std::string describe(const SafeRange& range)
{
    const auto face = [](const SafeReach& end) {
        return end.face < 0 ? std::string("nothing breaks") : join("face ", end.face, " breaks");
    };
    return join("safe range of the line: ", range.low.reach, " (", face(range.low), ") to ",
                range.high.reach, " (", face(range.high), ")");
}

/// Says how far blends may leave the inputs and refuses those that go farther, unless forced.
/// @return The fields `safe_range` (of lines) and `safe_reach` (per blend, see safe_range.h; null
///     where nothing ever breaks).
Json check_safe_range(const Session& session, const Arguments& arguments, const Blends& blends,
                      const Topology& topology, const ShapeVectors& vectors)
{
    Json figures = Json::object();
    if (!arguments.path.extrapolate)
        return figures;
    std::string said;
    if (blends.kind == PathKind::Line) {
        const SafeRange range = safe_range_of_line(topology, vectors, arguments.lengths);
        said = describe(range);
        figures["safe_range"] = {{"low", finite_or_null(range.low.reach)},
                                 {"high", finite_or_null(range.high.reach)},
                                 {"low_face", range.low.face},
                                 {"high_face", range.high.face}};
    }
    Json reaches = Json::array();
    for (std::size_t i = 0; i < blends.weights.size(); ++i) {
        const SafeReach safe = safe_reach(topology, vectors, blends.weights[i], arguments.lengths);
        reaches.push_back(finite_or_null(safe.reach));
        if (safe.reach <= 1.0 && !arguments.path.force_range)
            throw InvalidInput(join(numbered_name("frame", i), " leaves the safe range: face ",
                                    safe.face, " breaks its triangle inequality after ", safe.reach,
                                    " of the way beyond the inputs; ", said,
                                    said.empty() ? "" : "; ", "--force-range goes on"));
    }
    figures["safe_reach"] = reaches;
    if (!said.empty())
        session.message(said);
    return figures;
}

Json weight_figures(const Blends& blends)
{
    Json figures = Json::array();
    for (const Eigen::VectorXd& weights : blends.weights)
        figures.push_back(std::vector<double>(weights.begin(), weights.end()));
    return figures;
}

std::vector<std::filesystem::path> all_inputs(const Arguments& arguments)
{
    std::vector<std::filesystem::path> files = input_files(arguments.meshes);
    for (const std::string& file :
         {arguments.path.file, arguments.part.vertices, arguments.part.faces})
        if (!file.empty())
            files.emplace_back(file);
    return files;
}

/// What the meshes of all shards depend on.
/// @param target  Of weights.
Json settings_of(const Session& session, const Arguments& arguments, const Collection& collection,
                 const Blends& blends,
                 const std::function<ShapePoint(const Eigen::VectorXd&)>& target)
{
    Json settings = file_settings(session, arguments.embedding, arguments.output);
    const auto hash = [](const auto& array, const std::string& before) {
        return hash_text(array.data(), to_size(array.size()) * sizeof(double), before);
    };
    std::string all;
    for (const Points& points : collection.points)
        all = hash(points, all);
    settings["meshes"] = all;
    for (const Eigen::VectorXd& weights : blends.weights) {
        const ShapePoint point = target(weights);
        all = hash(point.dihedral_angles, hash(point.edge_lengths, all));
    }
    settings["targets"] = all;
    return settings;
}

void run(const Session& session, const Arguments& arguments)
{
    const Collection collection = read_meshes(session, arguments.meshes);
    const Topology& topology = collection.topology;
    if (collection.size() < 2)
        throw InvalidInput(join("one mesh cannot be blended; give two or more (",
                                collection.names.front(), " is the only one)"));
    const Blends blends = blends_of(arguments.path, static_cast<int>(collection.size()));
    const TaggedPart part = read_tagged_part(arguments.part, topology, collection.size());
    const ShapeVectors vectors = shape_vectors(collection, Scale::None);

    const Shard& shard = arguments.shard;
    if (shard.is_given() && blends.is_sequence)
        throw UsageError(
            "--shard and mpirun are for blends that are not a path: a frame of a path is placed as "
            "the one before it");
    const auto target = [&](const Eigen::VectorXd& weights) {
        return part.scale(blend(vectors, weights, arguments.lengths), weights);
    };
    Sequence sequence{topology, collection.points, {}, blends.is_sequence};
    for (const std::size_t i : shard.own(blends.weights.size()))
        sequence.targets.push_back(
            {numbered_name("frame", i),
             [&target, &weights = blends.weights[i]] { return target(weights); }});
    if (!blends.places.empty()) {
        TargetPath path{[&](double t) { return target(blends.weights_at(t)); }, blends.stations};
        sequence.along = FramePath{std::move(path), blends.places};
    }
    check_merged_output(shard, arguments.output.path);
    MeshOutputArguments place = arguments.output;
    if (shard.is_given())
        place.path = shard.directory(place.path).string() + "/";
    MeshOutput output(session, place, names(sequence.targets), all_inputs(arguments));
    Json figures = check_safe_range(session, arguments, blends, topology, vectors);
    figures.update(embed_sequence(session, arguments.embedding, arguments.sequence, sequence,
                                  place.path, output));
    if (shard.is_given())
        write_shard_manifest(place.path, shard, blends.weights.size(),
                             settings_of(session, arguments, collection, blends, target),
                             relative_to(place.path, output.paths()));
    merge_shards_of_ranks(session, arguments.output.path);
    figures["weights"] = weight_figures(blends);
    session.print_figures(figures);
}

} // namespace

Run set_up_interpolate(CLI::App& command)
{
    command.description(
        "Blend two or more meshes in edge-length space, at single places or along a path. Each\n"
        "blend is written as a mesh (frame_0000.ply, frame_0001.ply, ...); the first is turned\n"
        "and placed as the first mesh is, each further frame of a path as the one before it.");
    command.footer(
        "Examples:\n"
        "  shape interpolate a.ply b.ply -o frames/ --frames 11\n"
        "  shape interpolate a.ply b.ply -o animation.glb --frames 50 --fps 25\n"
        "  shape interpolate a.ply b.ply c.ply -o mean.ply --weights 0.25,0.25,0.5\n"
        "  shape interpolate a.ply b.ply -o frames/ --frames 7 --range -0.25:1.25 --extrapolate\n"
        "  shape interpolate a.ply b.ply c.ply d.ply -o patch/ --path bilinear --grid 5,5\n"
        "  shape interpolate poses/ -o frames/ --path spline --frames 200 --keyframes 20");
    const auto arguments = std::make_shared<Arguments>();
    add_mesh_input(command, arguments->meshes);
    arguments->meshes.may_repeat = true;
    add_mesh_output(command, arguments->output);
    add_animation_options(command, arguments->output);
    add_path_options(command, arguments->path);
    add_choice(
        command, "--lengths", arguments->lengths,
        "What is combined: plain lengths (default) or squared lengths (Rojas 2014, section 6)",
        {{"plain", LengthBlend::Plain}, {"squared", LengthBlend::Squared}});
    add_tagged_part_options(command, arguments->part);
    add_sequence_options(command, arguments->sequence);
    add_shard(command, arguments->shard);
    add_embedding_options(command, arguments->embedding);
    return [arguments](const Session& session) { run(session, *arguments); };
}

} // namespace shape::tools
