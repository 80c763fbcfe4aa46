// SPDX-License-Identifier: MIT

#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "libshape/embedding/frame_embedder.h"
#include "tools/output/embedding_run.h"

namespace shape::tools {

/// What makes the meshes between keyframes.
enum class Between
{
    Multiscale,
    Dihedral,
    Closure,
    Linear,
    Spline,
};

struct SequenceArguments
{
    std::int64_t keyframes = 0; ///< Every N-th mesh is embedded; 0: all of them are.
    Between between = Between::Multiscale;
    bool resume = false;
};

/// Adds --keyframes, --between and --resume.
void add_sequence_options(CLI::App& command, SequenceArguments& arguments);

/// What a run of several meshes is made from.
struct Sequence
{
    Topology topology;
    std::vector<Points> references; ///< As Embedder takes them.
    std::vector<EmbeddingTarget> targets;
    bool is_path =
        false; ///< Each mesh is turned and placed as the one before it; else as the first
               ///< reference. The first is placed so always.

    /// The path that all targets are frames of; none: they are embedded by themselves. Keyframes always are.
    std::optional<internal::FramePath> along = {};
};

/// Does what embed_and_write() does, by keyframes if wanted, and keeps finished meshes beside the
/// output until all are (frame_store.h).
/// @param path  The -o of the run.
/// @throws Interrupted saying where finished meshes are kept, if there are any; else as
///     embed_and_write() and FrameStore.
[[nodiscard]] Json embed_sequence(const Session& session, const EmbeddingArguments& embedding,
                                  const SequenceArguments& arguments, const Sequence& sequence,
                                  const std::string& path, MeshOutput& output);

} // namespace shape::tools
