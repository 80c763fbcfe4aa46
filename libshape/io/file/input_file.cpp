// SPDX-License-Identifier: MIT

#include "libshape/io/file/input_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/to_size.h"

namespace shape::internal {
namespace {

/// A regular file open for reading.
class InputFile
{
public:
    InputFile(const std::filesystem::path& path, std::uint64_t limit) : path_(path.string())
    {
        // O_NONBLOCK: opening a FIFO must not wait for a writer.
        descriptor_ = ::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC | O_NOCTTY);
        if (descriptor_ < 0)
            fail(std::strerror(errno));
        try {
            measure(limit);
        } catch (...) {
            ::close(descriptor_);
            throw;
        }
    }
    ~InputFile() { ::close(descriptor_); }
    InputFile(const InputFile&) = delete;
    InputFile& operator=(const InputFile&) = delete;

    [[nodiscard]] std::uint64_t size() const { return size_; }

    [[nodiscard]] std::string content() const
    {
        std::string content(size_, '\0');
        std::size_t done = 0;
        while (done < content.size()) {
            const ssize_t got = ::read(descriptor_, content.data() + done, content.size() - done);
            if (got < 0 && errno == EINTR)
                continue;
            if (got < 0)
                fail(std::strerror(errno));
            if (got == 0)
                fail("became shorter while it was read");
            done += to_size(got);
        }
        return content;
    }

private:
    [[noreturn]] void fail(const char* cause) const
    {
        throw FileError(join("cannot read ", path_, ": ", cause));
    }

    void measure(std::uint64_t limit)
    {
        struct stat status = {};
        if (::fstat(descriptor_, &status) != 0)
            fail(std::strerror(errno));
        if (!S_ISREG(status.st_mode))
            fail(S_ISDIR(status.st_mode) ? "is a directory" : "is not a regular file");
        size_ = static_cast<std::uint64_t>(status.st_size);
        if (size_ > limit)
            throw LimitExceeded(
                join(path_, ": has ", size_, " bytes; the limit is ", limit, " bytes"));
    }

    std::string path_;
    int descriptor_ = -1;
    std::uint64_t size_ = 0;
};

} // namespace

std::string read_file(const std::filesystem::path& path, std::uint64_t limit)
{
    return InputFile(path, limit).content();
}

std::uint64_t checked_file_size(const std::filesystem::path& path, std::uint64_t limit)
{
    return InputFile(path, limit).size();
}

} // namespace shape::internal
