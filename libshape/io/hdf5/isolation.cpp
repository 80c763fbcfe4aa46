// SPDX-License-Identifier: MIT

#include "libshape/io/hdf5/isolation.h"

#include <fcntl.h>
#include <hdf5.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <exception>
#include <mutex>
#include <new>
#include <optional>
#include <string>
#include <utility>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/memory_limit.h"
#include "libshape/io/hdf5/content_bytes.h"
#include "libshape/io/hdf5/untrusted_files.h"

namespace shape {

namespace {

std::atomic<bool> is_wanted{false};

} // namespace

void isolate_hdf5_files(bool wanted)
{
    is_wanted = wanted;
}

namespace internal {
namespace {

// Exit codes of a child beside 0.
constexpr int out_of_memory = 2;
constexpr int cut_off = 3;

/// The two ends of a pipe.
class Pipe
{
public:
    Pipe()
    {
        if (::pipe2(ends_.data(), O_CLOEXEC) != 0)
            throw LimitExceeded(join("no pipe can be made: ", std::strerror(errno)));
    }
    ~Pipe()
    {
        close_end(0);
        close_end(1);
    }
    Pipe(const Pipe&) = delete;
    Pipe& operator=(const Pipe&) = delete;

    void close_end(std::size_t end)
    {
        if (ends_[end] >= 0)
            ::close(std::exchange(ends_[end], -1));
    }

    /// @returns false if nobody reads any more.
    [[nodiscard]] bool write(std::string_view bytes) const
    {
        while (!bytes.empty()) {
            const ssize_t written = ::write(ends_[1], bytes.data(), bytes.size());
            if (written < 0 && errno != EINTR)
                return false;
            bytes.remove_prefix(written > 0 ? static_cast<std::size_t>(written) : 0);
        }
        return true;
    }

    /// @returns how many came before the other end was closed.
    [[nodiscard]] std::size_t read(char* bytes, std::size_t size) const
    {
        std::size_t done = 0;
        while (done < size) {
            const ssize_t got = ::read(ends_[0], bytes + done, size - done);
            if (got == 0 || (got < 0 && errno != EINTR))
                break;
            done += got > 0 ? static_cast<std::size_t>(got) : 0;
        }
        return done;
    }

private:
    std::array<int, 2> ends_{-1, -1}; ///< For reading, for writing.
};

/// Of the two strings that a child passes on: the content without its values, and these.
using Sizes = std::array<std::uint64_t, 2>;

/// What a child may need, and pass on, of a file of that size [byte].
std::uint64_t most_memory(std::uint64_t size)
{
    return (std::uint64_t{256} << 20) + 4 * size;
}

void lower_limit(__rlimit_resource resource, std::uint64_t value)
{
    rlimit limit{};
    if (getrlimit(resource, &limit) != 0)
        return;
    limit.rlim_cur = std::min<rlim_t>(limit.rlim_cur, value);
    setrlimit(resource, &limit);
}

void lower_limits(std::uint64_t size)
{
    const std::uint64_t seconds = 5 + (size >> 24); // 16 MiB a second on a busy machine
    lower_limit(RLIMIT_CORE, 0);
    lower_limit(RLIMIT_CPU, seconds);
#if !defined(__SANITIZE_ADDRESS__) // which maps terabytes
    lower_limit(RLIMIT_AS, address_space() + most_memory(size));
#endif
    alarm(static_cast<unsigned>(6 * seconds));
}

/// What the child does.
[[noreturn]] void pass_on(const std::filesystem::path& path, std::uint64_t size, Pipe& pipe)
{
    pipe.close_end(0); // so that writing ends when the parent does
    const int nowhere = open("/dev/null", O_WRONLY | O_CLOEXEC);
    dup2(nowhere, STDOUT_FILENO); // of a C library that finds its heap damaged
    dup2(nowhere, STDERR_FILENO);
    ::close(nowhere); // where few files may be open, the one to be read needs its place
    for (const int signal :
         {SIGALRM, SIGXCPU, SIGTERM, SIGINT, SIGSEGV, SIGABRT, SIGBUS, SIGFPE, SIGPIPE})
        std::signal(signal, SIG_DFL);
    lower_limits(size);
    // What a file asks for fails both times; memory that the machine lacked for a moment does not.
    for (int attempt = 0; attempt < 2; ++attempt)
        try {
            const FileContent content = read_content(path, size);
            const std::string declarations = to_bytes(content);
            const Sizes sizes{declarations.size(), content.values.size()};
            const bool is_passed =
                pipe.write({reinterpret_cast<const char*>(sizes.data()), sizeof(sizes)}) &&
                pipe.write(declarations) && pipe.write(content.values);
            _exit(is_passed ? 0 : cut_off);
        } catch (const std::bad_alloc&) {
        } catch (const std::exception&) {
            _exit(1);
        }
    _exit(out_of_memory);
}

/// What came, if it came whole and makes sense.
std::optional<FileContent> receive(const Pipe& pipe, std::uint64_t size)
{
    Sizes sizes{};
    if (pipe.read(reinterpret_cast<char*>(sizes.data()), sizeof(sizes)) < sizeof(sizes) ||
        *std::ranges::max_element(sizes) > most_memory(size))
        return {};
    std::string declarations(sizes[0], '\0');
    std::string values(sizes[1], '\0');
    if (pipe.read(declarations.data(), declarations.size()) < declarations.size() ||
        pipe.read(values.data(), values.size()) < values.size())
        return {};
    std::optional<FileContent> content = from_bytes(declarations);
    if (content)
        content->values = std::move(values);
    return content;
}

[[noreturn]] void fail(const std::filesystem::path& path, const std::string& how)
{
    throw InvalidInput(join(path.string(),
                            ": the HDF5 file is damaged, perhaps on purpose: a process "
                            "that only read it ",
                            how));
}

std::string ending(int signal)
{
    if (signal == SIGXCPU || signal == SIGALRM || signal == SIGKILL)
        return "took too long (a sound one may have too many members)";
    return join("crashed (signal ", signal, ")");
}

/// Address space that reading takes for sure [byte].
std::uint64_t least_memory(std::uint64_t size)
{
    return (std::uint64_t{64} << 20) + 2 * size;
}

/// A process that has been forked. Ended and waited for when this goes.
class Child
{
public:
    explicit Child(pid_t process) : process_(process) {}
    ~Child()
    {
        if (process_ > 0) {
            ::kill(process_, SIGKILL);
            (void)wait();
        }
    }
    Child(const Child&) = delete;
    Child& operator=(const Child&) = delete;

    /// @returns its status; none if the program lets the system collect its children (ECHILD).
    std::optional<int> wait()
    {
        int status = 0;
        const pid_t process = std::exchange(process_, -1);
        while (waitpid(process, &status, 0) < 0)
            if (errno != EINTR)
                return {};
        return status;
    }

private:
    pid_t process_;
};

FileContent read_content_in_child(const std::filesystem::path& path, std::uint64_t size)
{
    H5open(); // here, once, and not in each child
    Pipe pipe;
    const pid_t process = fork();
    if (process == 0)
        pass_on(path, size, pipe);
    if (process < 0)
        throw LimitExceeded(
            join(path.string(), ": no process can be started to read it: ", std::strerror(errno)));
    Child child(process);
    pipe.close_end(1); // so that reading ends when the child does
    const bool is_tight = address_space_left() < least_memory(size);
    std::optional<FileContent> content = receive(pipe, size);
    pipe.close_end(0); // so that the child does not wait for us, whatever it still writes
    const std::optional<int> status = child.wait();
    if (content && (!status || *status == 0))
        return *std::move(content);
    if (is_tight) // HDF5 does not survive every allocation that fails
        throw LimitExceeded(join(path.string(), ": too little memory to read it safely: ",
                                 address_space_left() >> 20, " MiB of address space are left, ",
                                 least_memory(size) >> 20, " MiB are needed (ulimit -v)"));
    if (status && WIFEXITED(*status) && WEXITSTATUS(*status) == cut_off)
        throw FileError(
            join("cannot read ", path.string(), ": a pipe between two processes broke; try again"));
    if (status && WIFSIGNALED(*status))
        fail(path, ending(WTERMSIG(*status)));
    if (status && WEXITSTATUS(*status) == out_of_memory)
        fail(path, "ran out of memory, more than a file of its size needs");
    if (status && WEXITSTATUS(*status) != 0)
        fail(path, join("ended with exit code ", WEXITSTATUS(*status)));
    fail(path, "passed on what makes no sense");
}

} // namespace

FileContent read_content_isolated_if_wanted(const std::filesystem::path& path, std::uint64_t size)
{
    if (!is_wanted)
        return read_content(path, size);
    static std::mutex mutex; // a child holds open what others have open just then
    const std::lock_guard lock(mutex);
    return read_content_in_child(path, size);
}

} // namespace internal
} // namespace shape
