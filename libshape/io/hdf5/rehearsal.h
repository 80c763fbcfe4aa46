// SPDX-License-Identifier: MIT

#pragma once

#include <filesystem>

namespace shape::internal {

/// Reads the whole file in a child process first, if rehearse_hdf5_files() (untrusted_files.h) has been
/// asked for. Once for a file that stays as it is.
/// @throws InvalidInput if that process crashes or needs too much time or memory.
/// @throws LimitExceeded if it cannot be started.
void rehearse_if_wanted(const std::filesystem::path& path);

/// Whether the file that was opened last was read to its end in its rehearsal: what memory its reading asks
/// for is not the file's fault then.
[[nodiscard]] bool was_sound_in_rehearsal();

} // namespace shape::internal
