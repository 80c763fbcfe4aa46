// SPDX-License-Identifier: MIT

#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace shape::internal {

/// The whole content of a regular file; a FIFO, device or directory is refused without being read.
/// @throws FileError if it cannot be read; LimitExceeded if it is larger than `limit` bytes.
[[nodiscard]] std::string read_file(const std::filesystem::path& path, std::uint64_t limit);

/// Size of a regular file [byte].
/// @throws as read_file().
[[nodiscard]] std::uint64_t checked_file_size(const std::filesystem::path& path,
                                              std::uint64_t limit);

} // namespace shape::internal
