// SPDX-License-Identifier: MIT

#include "tools/output/sequence_run.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/to_size.h"
#include "libshape/embedding/in_betweens.h"
#include "libshape/io/table_file.h"
#include "tools/output/embedding_settings.h"
#include "tools/output/frame_store.h"
#include "tools/program/arguments.h"

namespace shape::tools {
using namespace internal;
namespace {

const std::vector<std::pair<std::string, Between>> between_choices{
    {"multiscale", Between::Multiscale},
    {"dihedral", Between::Dihedral},
    {"closure", Between::Closure},
    {"linear", Between::Linear},
    {"spline", Between::Spline}};

std::string between_name(Between between)
{
    for (const auto& [text, value] : between_choices)
        if (value == between)
            return text;
    return "";
}

std::string hash_of(const std::string& before, const Eigen::VectorXd& vector)
{
    return hash_text(vector.data(), to_size(vector.size()) * sizeof(double), before);
}

/// Sequences are made of points of edge-length space.
ShapePoint point_of(const EmbeddingTarget& target)
{
    return std::get<ShapePoint>(target.shape());
}

/// Everything that the meshes of a run depend on, to tell whether it can go on.
Json identity(const Session& session, const EmbeddingOptions& options,
              const SequenceArguments& arguments, const Sequence& sequence)
{
    const Faces& faces = sequence.topology.faces();
    std::string inputs = hash_text(faces.data(), to_size(faces.size()) * sizeof(int));
    for (const Points& points : sequence.references)
        inputs = hash_of(inputs, points.reshaped());
    std::string blends = join(sequence.targets.size(), sequence.is_path ? " frames " : " blends ");
    for (const EmbeddingTarget& target : sequence.targets) {
        const ShapePoint point = point_of(target);
        blends = hash_of(hash_of(hash_of(blends, point.edge_lengths), point.dihedral_angles),
                         point.patch_turns);
    }
    Json all = embedding_settings(session, options);
    all.update({{"meshes", inputs},
                {"blends", blends},
                {"path", sequence.along ? join(sequence.along->places.size(), " places") : "none"},
                {"--keyframes", join(arguments.keyframes)},
                {"--between", between_name(arguments.between)}});
    return all;
}

/// The method that fills in, if one does.
std::optional<EmbeddingMethod> filling_method(Between between)
{
    switch (between) {
        case Between::Multiscale:
            return EmbeddingMethod::Multiscale;
        case Between::Dihedral:
            return EmbeddingMethod::Dihedral;
        case Between::Closure:
            return EmbeddingMethod::Closure;
        case Between::Linear:
        case Between::Spline:
            break;
    }
    return std::nullopt;
}

/// The options of the keyframes.
/// @throws UsageError if one is given that neither they nor what fills in take.
EmbeddingOptions keyframe_options(const Session& session, const EmbeddingArguments& embedding,
                                  const SequenceArguments& arguments)
{
    std::vector<EmbeddingMethod> used{embedding.options.method};
    if (arguments.keyframes > 0 && embedding.options.avoid_contact &&
        !filling_method(arguments.between))
        throw UsageError(
            join("--avoid-contact does not go with --between ", between_name(arguments.between),
                 ", which moves vertices from keyframe to keyframe and embeds nothing"));
    if (arguments.keyframes > 0)
        if (const auto filling = filling_method(arguments.between))
            used.push_back(*filling);
    check_methods(embedding.options, used);
    return options_of(session, embedding.options.method, embedding.options);
}

InBetweens in_betweens(const Session& session, const EmbeddingOptions& given, Between between,
                       const Sequence& sequence, std::vector<Keyframe> keyframes)
{
    const std::optional<EmbeddingMethod> method = filling_method(between);
    if (!method)
        return {sequence.topology, std::move(keyframes),
                between == Between::Linear ? KeyframeMotion::Linear : KeyframeMotion::Spline};
    EmbeddingOptions filler = options_of(session, *method, given);
    if (method == EmbeddingMethod::Dihedral)
        filler.quality = EmbeddingQuality::Preview; // it starts from what is nearly a mesh
    return {sequence.topology, std::move(keyframes), sequence.references, filler};
}

/// Makes the meshes of a sequence in order, or takes those that are finished.
class Maker
{
public:
    /// @param along, progress  As FrameEmbedder takes them.
    Maker(const EmbeddingOptions& options, const Sequence& sequence,
          const std::optional<FramePath>& along, FrameStore& store, const Progress& progress)
        : sequence_(sequence),
          store_(store),
          method_(name(options.method)),
          embedder_(sequence.topology, sequence.references, options, along, progress),
          previous_(sequence.references.front())
    {
    }

    /// Every N-th target becomes a keyframe, and the last.
    [[nodiscard]] std::vector<Keyframe> keyframes(const Progress& progress, std::size_t every)
    {
        const std::size_t last = sequence_.targets.size() - 1;
        std::vector<Keyframe> keys;
        for (std::size_t i = 0; i <= last; i = i == last ? last + 1 : std::min(i + every, last)) {
            progress("embedding keyframes", i, last);
            const ShapePoint point = point_of(sequence_.targets[i]);
            keys.push_back({static_cast<double>(i), point, embedded(i, point).points});
        }
        progress("embedding keyframes", last, last);
        return keys;
    }

    /// The mesh by the method of the run.
    [[nodiscard]] FinishedMesh embedded(std::size_t i, const ShapePoint& point)
    {
        FinishedMesh mesh = taken_or_made(i, [&] {
            return finish(sequence_.targets[i].name, method_,
                          [&] { return embedder_.embed(i, point, previous_); });
        });
        if (sequence_.is_path)
            previous_ = mesh.points;
        return mesh;
    }

    /// The mesh from the keyframes around it.
    [[nodiscard]] FinishedMesh filled(std::size_t i, const ShapePoint& point,
                                      const InBetweens& between, const std::string& method) const
    {
        return taken_or_made(i, [&] {
            return finish(sequence_.targets[i].name, method,
                          [&] { return between.embed(static_cast<double>(i), point); });
        });
    }

private:
    template <class Make>
    [[nodiscard]] FinishedMesh taken_or_made(std::size_t i, const Make& make) const
    {
        std::optional<FinishedMesh> finished = store_.read(i);
        if (finished && finished->points.rows() == sequence_.topology.vertex_count())
            return *std::move(finished);
        FinishedMesh mesh = make();
        if (sequence_.targets.size() > 1)
            store_.write(i, mesh);
        return mesh;
    }

    const Sequence& sequence_;
    FrameStore& store_;
    std::string method_;
    FrameEmbedder embedder_;
    Points previous_; ///< What the next mesh is placed as.
};

Json run(const Session& session, const EmbeddingArguments& embedding,
         const SequenceArguments& arguments, const Sequence& sequence, FrameStore& store,
         MeshOutput& output)
{
    const EmbeddingOptions options = keyframe_options(session, embedding, arguments);
    const TargetOrder order = sequence.is_path ? TargetOrder::Sequence : TargetOrder::Any;
    Maker maker(options, sequence, arguments.keyframes == 0 ? sequence.along : std::nullopt, store,
                session.progress());
    if (arguments.keyframes == 0)
        return make_and_write(
            session, embedding, sequence.topology, sequence.targets,
            [&](std::size_t i, const DecodedShape& shape) {
                return maker.embedded(i, std::get<ShapePoint>(shape));
            },
            output, order);
    const auto every = to_size(arguments.keyframes);
    const InBetweens between = in_betweens(session, embedding.options, arguments.between, sequence,
                                           maker.keyframes(session.progress(), every));
    return make_and_write(
        session, embedding, sequence.topology, sequence.targets,
        [&](std::size_t i, const DecodedShape& shape) {
            return maker.filled(i, std::get<ShapePoint>(shape), between,
                                between_name(arguments.between));
        },
        output, order);
}

std::string what_is_kept(const FrameStore& store, std::size_t total)
{
    return join(store.count(), " of ", total, " meshes are kept in ", store.directory(),
                "; the same command with --resume goes on");
}

} // namespace

void add_sequence_options(CLI::App& command, SequenceArguments& arguments)
{
    const std::string group = "Sequences";
    CLI::Option* keyframes = add_integer(
        command, "--keyframes", arguments.keyframes,
        "Embed every N-th frame and the last by --method, and fill in between; >= 2", 2, 1'000'000);
    keyframes->group(group);
    add_choice(command, "--between", arguments.between,
               "What fills in: multiscale (default), dihedral (a few steps) or closure, their\n"
               "targets corrected so that the sequence passes through the keyframes smoothly; or\n"
               "the vertices move on straight lines (linear) or a smooth curve (spline)",
               between_choices)
        ->needs(keyframes)
        ->group(group);
    command
        .add_flag(
            "--resume", arguments.resume,
            "Go on with an interrupted run: finished meshes wait in OUTPUT.unfinished, or in\n"
            "OUTPUT/unfinished if that directory existed. The result is the same to the bit")
        ->group(group);
}

Json embed_sequence(const Session& session, const EmbeddingArguments& embedding,
                    const SequenceArguments& arguments, const Sequence& sequence,
                    const std::string& path, MeshOutput& output)
{
    if (arguments.keyframes > 0 && !sequence.is_path)
        throw UsageError("--keyframes needs --frames: only a path has meshes in between");
    (void)keyframe_options(session, embedding, arguments); // refuses before anything is made
    prepare_output(embedding, sequence.topology, sequence.targets, output);
    FrameStore store(session, path, identity(session, embedding.options, arguments, sequence),
                     arguments.resume);
    const std::size_t total = sequence.targets.size();
    if (arguments.resume)
        session.message(join(store.count(), " of ", total, " meshes are finished already"));
    try {
        return run(session, embedding, arguments, sequence, store, output);
    } catch (const Interrupted&) {
        if (!store.keep())
            throw;
        throw Interrupted(join("interrupted; ", what_is_kept(store, total)));
    } catch (const FileError& error) { // such as a full disk
        if (!store.keep())
            throw;
        throw FileError(join(error.what(), "; ", what_is_kept(store, total)));
    }
}

} // namespace shape::tools
