// SPDX-License-Identifier: MIT

#pragma once

#include <cstdint>
#include <filesystem>

#include "libshape/io/hdf5/file_content.h"

namespace shape::internal {

/// read_content(), by a child process if isolate_hdf5_files() (untrusted_files.h) has been asked for.
/// @param size  Of the file [byte].
/// @throws InvalidInput if that process crashes or needs too much time or memory.
/// @throws FileError if the pipe to that process breaks.
/// @throws LimitExceeded if it cannot be started, or has too little memory for any file of that size.
[[nodiscard]] FileContent read_content_isolated_if_wanted(const std::filesystem::path& path,
                                                          std::uint64_t size);

} // namespace shape::internal
