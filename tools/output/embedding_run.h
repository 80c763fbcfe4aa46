// SPDX-License-Identifier: MIT

#pragma once

#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "libshape/edge_space/shape_space.h"
#include "libshape/embedding/embedder.h"
#include "libshape/embedding/frame_embedder.h"
#include "tools/output/mesh_output.h"
#include "tools/program/session.h"

namespace CLI {
class App;
}

namespace shape::tools {

/// The arguments that every command shares that makes meshes from points of the space.
struct EmbeddingArguments
{
    EmbeddingOptions options; ///< As given: check_methods() says whether they go together.
    bool strict = false;      ///< An infeasible target ends the run before anything is written.
    bool residuals = false;   ///< Beside every mesh goes residuals/NAME_residuals.ply.
    bool verbose = false;     ///< Every infeasible target is described, not all in one line.
};

/// Adds --method, --quality, --smoothness, --anchor, --init and --avoid-contact.
/// @param smoothness  What the help says where none is given.
void add_embedder_options(CLI::App& command, EmbeddingOptions& options,
                          double smoothness = default_smoothness);

/// Adds those, --strict, --verbose and --residuals.
void add_embedding_options(CLI::App& command, EmbeddingArguments& arguments,
                           double smoothness = default_smoothness);

/// @throws UsageError if an option is given that belongs to none of the methods used.
void check_methods(const EmbeddingOptions& given, const std::vector<EmbeddingMethod>& used);

/// Those of the given options that belong to a method; the seed is that of the session.
[[nodiscard]] EmbeddingOptions options_of(const Session& session, EmbeddingMethod method,
                                          const EmbeddingOptions& given);

/// A mesh to be made. The shape is made when it is needed: all of them may not fit into memory.
struct EmbeddingTarget
{
    std::string name;
    std::function<DecodedShape()> shape;
    const Points* place = nullptr; ///< A mesh that the result is moved rigidly onto, if any.
    std::size_t frame = 0;         ///< Its number on the path, if it is of one.
    double resized =
        1.0; ///< The mesh is made at the size of the shape and multiplied by this, before `place`.
};

/// A mesh as it is written, and what is said about it.
struct FinishedMesh
{
    Points points;
    Json figures;       ///< One object of `embeddings`.
    std::string reason; ///< Why its target is infeasible; else empty.
};

/// What the order of the targets means.
enum class TargetOrder
{
    Any,
    Sequence, ///< Each is near the one before it: jumps between them are looked for.
};

/// Embeds all targets that are not meshes yet and writes them, target i into output i; prints a table
/// of what they are worth and warns of infeasible ones and of jumps.
/// @param references  As Embedder takes them.
/// @param along  The path that all targets, points of edge-length space, are frames of, all of its or some; none: they
///     are embedded by themselves.
/// @return The fields `outputs` and `embeddings`; `jumps` of a sequence; `animation` if one is
///     written.
/// @throws NumericalError if a target is infeasible and `strict` is set; InvalidInput and
///     NumericalError of the embedder, naming the target.
[[nodiscard]] Json embed_and_write(const Session& session, const EmbeddingArguments& arguments,
                                   const Topology& topology, std::vector<Points> references,
                                   const std::vector<EmbeddingTarget>& targets, MeshOutput& output,
                                   TargetOrder order = TargetOrder::Any,
                                   std::optional<internal::FramePath> along = {});

/// Makes the mesh of target `index`, whose shape is given.
using MeshMaker = std::function<FinishedMesh(std::size_t index, const DecodedShape& shape)>;

/// The second half of embed_and_write(): the same with meshes that come from elsewhere; they are made
/// in order.
[[nodiscard]] Json make_and_write(const Session& session, const EmbeddingArguments& arguments,
                                  const Topology& topology,
                                  const std::vector<EmbeddingTarget>& targets,
                                  const MeshMaker& make, MeshOutput& output, TargetOrder order);

/// The first half: what --residuals and --strict ask for before anything is embedded.
void prepare_output(const EmbeddingArguments& arguments, const Topology& topology,
                    const std::vector<EmbeddingTarget>& targets, MeshOutput& output);

/// What `embed` makes of a target, with its figures; errors name the target.
[[nodiscard]] FinishedMesh finish(const std::string& target, const std::string& method,
                                  const std::function<Embedding()>& embed);

/// Warns if the target of a mesh is infeasible.
void warn_if_infeasible(const Session& session, const std::string& target,
                        const FinishedMesh& mesh);

/// "dihedral", "closure" or "multiscale".
[[nodiscard]] const char* name(EmbeddingMethod method);

/// The options as the library takes them: options_of() the method.
/// @throws UsageError if an option belongs to another method.
[[nodiscard]] EmbeddingOptions embedding_options(const Session& session,
                                                 const EmbeddingOptions& given);

/// "frame_0007": a name with a number of at least four digits.
[[nodiscard]] std::string numbered_name(const std::string& stem, std::size_t number);

/// The names of the targets, in order.
[[nodiscard]] std::vector<std::string> names(const std::vector<EmbeddingTarget>& targets);

} // namespace shape::tools
