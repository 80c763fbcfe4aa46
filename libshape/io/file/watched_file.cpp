// SPDX-License-Identifier: MIT

#include "libshape/io/file/watched_file.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "libshape/base/error.h"
#include "libshape/base/format.h"

namespace shape::internal {

WatchedFile::WatchedFile(const std::filesystem::path& path) : path_(path)
{
    const auto fail = [&](const char* cause) {
        throw FileError(join("cannot write ", path.string(), ": ", cause));
    };
    descriptor_ = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOFOLLOW);
    if (descriptor_ < 0)
        fail(errno == ELOOP ? "is a symbolic link; name the file it points to"
                            : std::strerror(errno));
    if (::fstat(descriptor_, &status_) != 0) {
        const int error = errno;
        ::close(descriptor_);
        fail(std::strerror(error));
    }
}

WatchedFile::~WatchedFile()
{
    if (folder_ >= 0)
        ::close(folder_);
    ::close(descriptor_);
}

void WatchedFile::lock_folder()
{
    // Not the file, for other programs lock HDF5 files while they read them.
    const std::filesystem::path folder = path_.has_parent_path() ? path_.parent_path() : ".";
    folder_ = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    for (int attempt = 0; attempt < 100; ++attempt) {
        if (::flock(folder_, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK)
            break;
        ::usleep(10000);
    }
}

bool WatchedFile::is_as_it_was() const
{
    struct stat now = {};
    return ::lstat(path_.c_str(), &now) == 0 && now.st_dev == status_.st_dev &&
           now.st_ino == status_.st_ino && now.st_size == status_.st_size &&
           now.st_mtim.tv_sec == status_.st_mtim.tv_sec &&
           now.st_mtim.tv_nsec == status_.st_mtim.tv_nsec;
}

} // namespace shape::internal
