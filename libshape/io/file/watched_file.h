// SPDX-License-Identifier: MIT

#pragma once

#include <sys/stat.h>

#include <filesystem>

namespace shape::internal {

/// A file that is to be replaced by one made from it, as it was when it was opened here.
class WatchedFile
{
public:
    /// @throws FileError naming path and cause if it cannot be opened or is a symbolic link.
    explicit WatchedFile(const std::filesystem::path& path);
    ~WatchedFile();
    WatchedFile(const WatchedFile&) = delete;
    WatchedFile& operator=(const WatchedFile&) = delete;

    /// Locks the folder until the end of this object: of two that look and rename at once one waits,
    /// and then finds another file. Where the file system has no locks, or a stranger has this one for
    /// more than a second, the moment between looking and renaming is left.
    void lock_folder();

    /// Whether the path still leads to that file, of the same size and time of modification.
    [[nodiscard]] bool is_as_it_was() const;

private:
    std::filesystem::path path_;
    struct stat status_ = {};
    int descriptor_ = -1; ///< While it is open, no other file gets its inode.
    int folder_ = -1;
};

} // namespace shape::internal
