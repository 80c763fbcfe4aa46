// SPDX-License-Identifier: MIT

#pragma once

#include <filesystem>
#include <functional>
#include <string_view>

namespace shape::internal {

/// Writes a file so that nothing that existed is lost: `content` goes into a new hidden file beside
/// the target, which is synced and renamed into place. On any error that file is removed and the
/// target is as it was. Permissions follow the umask.
/// @param check  Called with the new file before the renaming; what it throws passes through.
/// @throws FileError naming path and cause if the directory is missing or not writable, the target
///     is not a regular file or has got to one of the FreePlaces meanwhile, or the system refuses.
void write_file_atomically(
    const std::filesystem::path& path, std::string_view content,
    const std::function<void(const std::filesystem::path& temporary)>& check = {});

/// The same with content that is not held together.
/// @param write  Called once with the new file, open for reading and writing; what it throws passes
///     through.
/// @param before_renaming  Called when the new file is synced, just before it takes the place of the target;
///     what it throws passes through.
void write_file_atomically(
    const std::filesystem::path& path, const std::function<void(int descriptor)>& write,
    const std::function<void(const std::filesystem::path& temporary)>& check = {},
    const std::function<void()>& before_renaming = {});

/// Renames a finished file or directory into its place on the same file system. A file that is there is replaced, but
/// not one that has got to one of the FreePlaces.
/// @throws FileError naming the place and the cause.
void move_into_place(const std::filesystem::path& finished, const std::filesystem::path& place);

} // namespace shape::internal
