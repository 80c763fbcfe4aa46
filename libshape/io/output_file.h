// SPDX-License-Identifier: MIT

#pragma once

#include <filesystem>
#include <functional>
#include <string_view>

namespace shape {

/// Writes a file so that nothing that existed is lost: `write` fills a new file beside the target,
/// which is then synced and renamed into place. On any error that file is removed and the target is
/// as it was.
/// @throws FileError naming path and cause if the directory is missing or not writable, the target
///     is no regular file, or the system refuses. What `write` throws passes through.
void write_file_atomically(const std::filesystem::path& path,
                           const std::function<void(const std::filesystem::path& temporary)>& write);

/// The same for text or bytes in memory.
void write_file_atomically(const std::filesystem::path& path, std::string_view content);

} // namespace shape
