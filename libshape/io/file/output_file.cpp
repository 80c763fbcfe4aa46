// SPDX-License-Identifier: MIT

#include "libshape/io/file/output_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstring>
#include <string>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/to_size.h"
#include "libshape/io/file/long_output.h"

namespace shape::internal {
namespace {

[[noreturn]] void fail(const std::filesystem::path& path, std::string_view cause)
{
    throw FileError(join("cannot write ", path.string(), ": ", cause));
}

/// A new hidden file beside the target; removed again unless it was moved into its place.
class TemporaryFile
{
public:
    explicit TemporaryFile(const std::filesystem::path& target)
        : target_(target), directory_path_(target.has_parent_path() ? target.parent_path() : ".")
    {
        if (!target.has_filename())
            fail(target, "the path names no file");
        directory_ = ::open(directory_path_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
        if (directory_ < 0)
            fail(target, join("directory ", directory_path_.string(), ": ", std::strerror(errno)));
        try {
            check_target();
            create();
        } catch (...) {
            ::close(directory_);
            throw;
        }
    }
    ~TemporaryFile()
    {
        if (!committed_)
            ::unlinkat(directory_, name_.c_str(), 0);
        ::close(descriptor_);
        ::close(directory_);
    }
    TemporaryFile(const TemporaryFile&) = delete;
    TemporaryFile& operator=(const TemporaryFile&) = delete;

    [[nodiscard]] std::filesystem::path path() const { return directory_path_ / name_; }
    [[nodiscard]] int descriptor() const { return descriptor_; }

    void write(std::string_view content)
    {
        while (!content.empty()) {
            const ssize_t done = ::write(descriptor_, content.data(), content.size());
            if (done < 0 && errno == EINTR)
                continue;
            if (done < 0)
                fail(target_, std::strerror(errno));
            content.remove_prefix(to_size(done));
        }
    }

    void commit(const std::function<void()>& before_renaming = {})
    {
        // Syncs the file whoever wrote it: the pages belong to the inode.
        if (::fsync(descriptor_) != 0)
            fail(target_, std::strerror(errno));
        if (before_renaming)
            before_renaming();
        if (::renameat(directory_, name_.c_str(), directory_, target_.filename().c_str()) != 0)
            fail(target_, std::strerror(errno));
        committed_ = true;
        // The new file is in place; some file systems cannot sync a directory, which is not an error.
        (void)::fsync(directory_);
    }

private:
    void check_target() const
    {
        struct stat status = {};
        if (::fstatat(directory_, target_.filename().c_str(), &status, AT_SYMLINK_NOFOLLOW) != 0) {
            if (errno != ENOENT)
                fail(target_, std::strerror(errno));
            return;
        }
        if (S_ISLNK(status.st_mode))
            fail(target_, "is a symbolic link; name the file it points to");
        if (!S_ISREG(status.st_mode))
            fail(target_, S_ISDIR(status.st_mode) ? "is a directory" : "is not a regular file");
    }

    void create()
    {
        static std::atomic<unsigned> counter{0};
        do {
            name_ = join(".shape-", ::getpid(), "-", counter++, ".tmp");
            descriptor_ = ::openat(directory_, name_.c_str(),
                                   O_RDWR | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0666);
        } while (descriptor_ < 0 && errno == EEXIST);
        if (descriptor_ < 0)
            fail(target_, join("directory ", directory_path_.string(), ": ", std::strerror(errno)));
    }

    std::filesystem::path target_;
    std::filesystem::path directory_path_;
    std::string name_;
    int directory_ = -1;
    int descriptor_ = -1;
    bool committed_ = false;
};

} // namespace

void write_file_atomically(const std::filesystem::path& path, std::string_view content,
                           const std::function<void(const std::filesystem::path&)>& check)
{
    TemporaryFile file(path);
    file.write(content);
    if (check)
        check(file.path());
    file.commit();
}

void write_file_atomically(const std::filesystem::path& path, const std::function<void(int)>& write,
                           const std::function<void(const std::filesystem::path&)>& check,
                           const std::function<void()>& before_renaming)
{
    TemporaryFile file(path);
    write(file.descriptor());
    if (check)
        check(file.path());
    file.commit(before_renaming);
}

void write_pieces_atomically(const std::filesystem::path& path,
                             const std::function<void(const AppendText&)>& make)
{
    TemporaryFile file(path);
    make([&](std::string_view text) { file.write(text); });
    file.commit();
}

} // namespace shape::internal
