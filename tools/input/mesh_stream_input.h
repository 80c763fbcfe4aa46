// SPDX-License-Identifier: MIT

#pragma once

#include <cstdint>
#include <optional>
#include <string>

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

} // namespace shape::tools
