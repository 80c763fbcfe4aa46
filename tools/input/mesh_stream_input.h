// SPDX-License-Identifier: MIT

#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "libshape/edge_space/shape_space.h"
#include "libshape/mesh/mesh_stream.h"
#include "tools/input/label_input.h"

namespace shape::tools {

/// What may be in memory.
struct MemoryArgument
{
    std::string text;        ///< As given: "500M", "8G".
    std::uint64_t bytes = 0; ///< 0: not given.
};

/// Adds --memory.
CLI::Option* add_memory(CLI::App& command, MemoryArgument& memory);

/// Where the input is one collection file whose positions take more than 32 MiB, that file, to be read
/// in passes; none where it is better held in memory. Labels and --only count as in read_labelled(),
/// and degenerate geometry is refused where a mesh is read first.
/// @param always  Whatever it takes.
[[nodiscard]] std::optional<MeshStream> open_labelled(const Session& session,
                                                      const LabelledInput& input, bool always);

/// open_labelled() for a command that can go over its meshes in passes in edge space: none where they are
/// to be read as a whole.
/// @param shares  Whether several processes share the passes.
/// @throws UsageError if that, or --memory, is asked for where passes cannot be taken.
[[nodiscard]] std::optional<MeshStream> open_for_passes(const Session& session,
                                                        const LabelledInput& input,
                                                        const SpaceOptions& space,
                                                        const MemoryArgument& memory,
                                                        bool shares = false);

} // namespace shape::tools
