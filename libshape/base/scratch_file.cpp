// SPDX-License-Identifier: MIT

#include "libshape/base/scratch_file.h"

#include <fcntl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <string>
#include <system_error>
#include <utility>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/to_size.h"

namespace shape::internal {
namespace {

int open_nameless(const std::filesystem::path& folder)
{
#ifdef O_TMPFILE
    const int descriptor =
        ::open(folder.c_str(), O_TMPFILE | O_RDWR | O_EXCL | O_CLOEXEC, S_IRUSR | S_IWUSR);
    if (descriptor >= 0)
        return descriptor;
#endif
    std::string name =
        (folder / ".shape-scratch-XXXXXX").string(); // not every file system has those
    const int named = ::mkstemp(name.data());
    if (named >= 0)
        ::unlink(name.c_str());
    return named;
}

/// Beyond it the system would not refuse, but end the process.
bool is_within_limit(std::uint64_t bytes)
{
    rlimit limit{};
    return ::getrlimit(RLIMIT_FSIZE, &limit) == 0 &&
           (limit.rlim_cur == RLIM_INFINITY || bytes <= limit.rlim_cur);
}

/// Calls move(done) until all bytes have moved.
template <class Move>
void move_all(std::size_t bytes, const char* what, const Move& move)
{
    for (std::size_t done = 0; done < bytes;) {
        const ssize_t moved = move(done);
        if (moved < 0 && errno == EINTR)
            continue;
        if (moved <= 0)
            throw FileError(join("cannot ", what, " measured rows on disk: ",
                                 moved < 0 ? std::strerror(errno) : "the file ends early"));
        done += to_size(moved);
    }
}

off_t offset_of(std::uint64_t first, std::size_t done)
{
    return static_cast<off_t>(first * sizeof(double) + done);
}

} // namespace

std::optional<ScratchFile> ScratchFile::make(const std::filesystem::path& folder,
                                             std::uint64_t bytes)
{
    std::error_code error;
    const std::filesystem::space_info space = std::filesystem::space(folder, error);
    if (error || space.available / 2 < bytes || !is_within_limit(bytes))
        return std::nullopt;
    ScratchFile file(open_nameless(folder));
    if (file.descriptor_ < 0 || ::fallocate(file.descriptor_, 0, 0, static_cast<off_t>(bytes)) != 0)
        return std::nullopt;
    return file;
}

ScratchFile::ScratchFile(ScratchFile&& other) noexcept
    : descriptor_(std::exchange(other.descriptor_, -1))
{
}

ScratchFile& ScratchFile::operator=(ScratchFile&& other) noexcept
{
    std::swap(descriptor_, other.descriptor_);
    return *this;
}

ScratchFile::~ScratchFile()
{
    if (descriptor_ >= 0)
        ::close(descriptor_);
}

void ScratchFile::write(std::uint64_t first, std::span<const double> numbers) const
{
    const auto* const from = reinterpret_cast<const char*>(numbers.data());
    move_all(numbers.size_bytes(), "keep", [&](std::size_t done) {
        return ::pwrite(descriptor_, from + done, numbers.size_bytes() - done,
                        offset_of(first, done));
    });
}

void ScratchFile::read(std::uint64_t first, std::span<double> numbers) const
{
    auto* const to = reinterpret_cast<char*>(numbers.data());
    move_all(numbers.size_bytes(), "read", [&](std::size_t done) {
        return ::pread(descriptor_, to + done, numbers.size_bytes() - done, offset_of(first, done));
    });
}

} // namespace shape::internal
