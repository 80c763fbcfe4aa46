// SPDX-License-Identifier: MIT

#pragma once

#include <functional>
#include <string>
#include <vector>

#include "libshape/edge_space/shape_space.h"
#include "libshape/embedding/embedder.h"
#include "tools/common/mesh_output.h"
#include "tools/common/session.h"

namespace CLI {
class App;
}

namespace shape::tools {

/// The arguments that every command shares that makes meshes from points of the space.
struct EmbeddingArguments
{
    EmbeddingOptions options;
    bool strict = false; ///< An infeasible target ends the run before anything is written.
};

/// Adds --method, --quality and --smoothness.
void add_embedder_options(CLI::App& command, EmbeddingOptions& options);

/// Adds those and --strict.
void add_embedding_options(CLI::App& command, EmbeddingArguments& arguments);

/// A mesh to be made. The shape is made when it is needed: all of them may not fit into memory.
struct EmbeddingTarget
{
    std::string name;
    std::function<DecodedShape()> shape;
    const Points* place = nullptr; ///< A mesh that the result is moved rigidly onto, if any.
};

/// Embeds all targets that are no meshes yet and writes them, target i into output i; prints a table of what they are
/// worth and warns of infeasible ones.
/// @param references  As Embedder takes them.
/// @return The fields `outputs` and `embeddings`.
/// @throws NumericalError if a target is infeasible and `strict` is set; InvalidInput and
///     NumericalError of the embedder, naming the target.
[[nodiscard]] Json embed_and_write(const Session& session, const EmbeddingArguments& arguments,
                                   const Topology& topology, std::vector<Points> references,
                                   const std::vector<EmbeddingTarget>& targets, MeshOutput& output);

/// "frame_0007": a name with a number of at least four digits.
[[nodiscard]] std::string numbered_name(const std::string& stem, std::size_t number);

/// The names of the targets, in order.
[[nodiscard]] std::vector<std::string> names(const std::vector<EmbeddingTarget>& targets);

} // namespace shape::tools
