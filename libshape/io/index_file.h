// SPDX-License-Identifier: MIT

#pragma once

#include <filesystem>
#include <string_view>
#include <vector>

namespace shape::internal {

/// Reads a list of vertices or faces: integers in [0, count), separated by blanks or line ends, in
/// any order; `#` starts a comment.
/// @param what  For messages: "vertex".
/// @throws FileError if the file cannot be read.
/// @throws InvalidInput naming file and line for anything else in it, or if it holds no index.
[[nodiscard]] std::vector<int> read_indices(const std::filesystem::path& path, int count,
                                            std::string_view what);

} // namespace shape::internal
