// SPDX-License-Identifier: MIT

#include "libshape/io/file/output_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <string>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/to_size.h"
#include "libshape/io/file/free_places.h"
#include "libshape/io/file/long_output.h"

namespace shape::internal {
namespace {

[[noreturn]] void fail(const std::filesystem::path& path, std::string_view cause)
{
    throw FileError(join("cannot write ", path.string(), ": ", cause));
}

[[noreturn]] void fail_for_newcomer(const std::filesystem::path& path)
{
    fail(path,
         "since this run began another one, or somebody, has put something there, which is left as "
         "it is; move it away or choose another name, then run again");
}

/// A name in a directory that is open, or of a path.
struct Place
{
    int directory = AT_FDCWD;
    const char* name = nullptr;
};

/// Renames, over what is there.
/// @return 0, or why not.
int rename_over(const Place& from, const Place& to)
{
    return ::renameat(from.directory, from.name, to.directory, to.name) == 0 ? 0 : errno;
}

/// Renames where nothing is: in one step, or where the file system has none, by a second name, which is refused as well
/// where something is. File systems without these either get a look before, which leaves a moment.
/// @return 0, or why not.
int rename_to_free(const Place& from, const Place& to)
{
    if (::renameat2(from.directory, from.name, to.directory, to.name, RENAME_NOREPLACE) == 0)
        return 0;
    if (errno != EINVAL && errno != ENOSYS)
        return errno;
    if (::linkat(from.directory, from.name, to.directory, to.name, 0) == 0) {
        (void)::unlinkat(from.directory, from.name, 0); // the file has its place all the same
        return 0;
    }
    struct stat status = {};
    if (errno == EEXIST || ::fstatat(to.directory, to.name, &status, AT_SYMLINK_NOFOLLOW) == 0)
        return EEXIST;
    return rename_over(from, to);
}

/// @param path  Of the new place, as it was given.
void rename_into_place(const Place& from, const Place& to, const std::filesystem::path& path)
{
    const bool must_be_free = FreePlaces::contain(path);
    const int error = must_be_free ? rename_to_free(from, to) : rename_over(from, to);
    if (must_be_free && error == EEXIST)
        fail_for_newcomer(path);
    if (error != 0)
        fail(path, std::strerror(error));
    FreePlaces::remove(path);
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
        rename_into_place({directory_, name_.c_str()}, {directory_, target_.filename().c_str()},
                          target_);
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
        if (FreePlaces::contain(target_)) // said before the work of writing, too
            fail_for_newcomer(target_);
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

void move_into_place(const std::filesystem::path& finished, const std::filesystem::path& place)
{
    rename_into_place({AT_FDCWD, finished.c_str()}, {AT_FDCWD, place.c_str()}, place);
}

void write_pieces_atomically(const std::filesystem::path& path,
                             const std::function<void(const AppendText&)>& make)
{
    TemporaryFile file(path);
    make([&](std::string_view text) { file.write(text); });
    file.commit();
}

} // namespace shape::internal
