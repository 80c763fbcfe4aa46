// SPDX-License-Identifier: MIT

#include "libshape/io/hdf5/rehearsal.h"

#include <fcntl.h>
#include <hdf5.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>
#if __has_include(<malloc.h>)
#include <malloc.h>
#endif

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <map>
#include <mutex>
#include <new>
#include <string>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/memory_limit.h"
#include "libshape/io/hdf5/reader.h"
#include "libshape/io/hdf5/untrusted_files.h"

namespace shape {

namespace {

std::atomic<bool> is_wanted{false};

} // namespace

void rehearse_hdf5_files(bool wanted)
{
    is_wanted = wanted;
}

namespace internal {
namespace {

/// What tells that a file is as it was: device, inode, size, and both times to the nanosecond.
using Identity = std::array<std::int64_t, 7>;

Identity identity(const struct stat& status)
{
    return {static_cast<std::int64_t>(status.st_dev),
            static_cast<std::int64_t>(status.st_ino),
            status.st_size,
            status.st_mtim.tv_sec,
            status.st_mtim.tv_nsec,
            status.st_ctim.tv_sec,
            status.st_ctim.tv_nsec};
}

void lower_limit(__rlimit_resource resource, std::uint64_t value)
{
    rlimit limit{};
    if (getrlimit(resource, &limit) != 0)
        return;
    limit.rlim_cur = std::min<rlim_t>(limit.rlim_cur, value);
    setrlimit(resource, &limit);
}

// Exit codes of a rehearsal beside 0.
constexpr int out_of_memory = 2;
constexpr int refused = 3;

/// The last rehearsal read its file to the end.
std::atomic<bool> is_sound{false};

/// From now on memory holds no numbers that were there before: what HDF5 takes for a pointer though it never set it is none, so
/// that the crash comes in the child, and not only in the second reading.
void spoil_memory()
{
#if defined(M_PERTURB)
    mallopt(M_PERTURB, 0x5a);
    constexpr std::size_t largest_cached =
        1032; // by glibc in each thread, as it was freed, seven of a size
    for (std::size_t size = 24; size <= largest_cached; size += 16)
        for (int i = 0; i < 7; ++i)
            if (void* taken = std::malloc(size)) // for good: the child soon ends
                std::memset(taken, 0x5a, size);
#endif
    H5garbage_collect();
    H5set_free_list_limits(0, 0, 0, 0, 0, 0); // HDF5's own
}

/// Reads what there is; refusals are not of interest here, the second reading names them.
[[noreturn]] void rehearse(const std::filesystem::path& path, std::uint64_t size)
{
    is_wanted = false;
    const int nowhere = open("/dev/null", O_WRONLY | O_CLOEXEC);
    dup2(nowhere, STDOUT_FILENO); // of a C library that finds its heap damaged
    dup2(nowhere, STDERR_FILENO);
    for (const int signal : {SIGALRM, SIGXCPU, SIGTERM, SIGINT, SIGSEGV, SIGABRT, SIGBUS, SIGFPE})
        std::signal(signal, SIG_DFL);
    const std::uint64_t seconds = 5 + (size >> 24); // 16 MiB a second on a busy machine
    lower_limit(RLIMIT_CORE, 0);
    lower_limit(RLIMIT_CPU, seconds);
#if !defined(__SANITIZE_ADDRESS__) // which maps terabytes
    lower_limit(RLIMIT_AS, address_space() + (std::uint64_t{256} << 20) + 2 * size);
#endif
    alarm(static_cast<unsigned>(6 * seconds));
    spoil_memory();
    // What a file asks for fails both times; memory that the machine lacked for a moment does not.
    for (int attempt = 0; attempt < 2; ++attempt)
        try {
            read_everything(Hdf5File(path));
            _exit(0);
        } catch (const std::bad_alloc&) { // before it came to what may crash
        } catch (const std::exception&) {
            _exit(refused);
        }
    _exit(out_of_memory);
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
        return "took too long";
    return join("crashed (signal ", signal, ")");
}

/// Address space that reading takes for sure [byte].
std::uint64_t room(std::uint64_t size)
{
    return (std::uint64_t{64} << 20) + 2 * size;
}

/// Rehearses in a child process and waits for its end.
void rehearse_apart(const std::filesystem::path& path, std::uint64_t size)
{
    H5open(); // here, where the second reading needs it too, and not in the child as well
    const pid_t child = fork();
    if (child == 0)
        rehearse(path, size);
    if (child < 0)
        throw LimitExceeded(join(
            path.string(), ": no process can be started to read it first: ", std::strerror(errno)));
    const bool is_tight = address_space_left() < room(size);
    int status = 0;
    while (waitpid(child, &status, 0) < 0)
        if (errno != EINTR)
            return; // ECHILD: the program lets the system collect its children; nothing is known
    const bool has_ended =
        WIFEXITED(status) && (WEXITSTATUS(status) == 0 || WEXITSTATUS(status) == refused);
    if (is_tight && !has_ended) // HDF5 does not survive every allocation that fails
        throw LimitExceeded(join(
            path.string(), ": too little memory to read it safely: ", address_space_left() >> 20,
            " MiB of address space are left, ", room(size) >> 20, " MiB are needed (ulimit -v)"));
    if (WIFSIGNALED(status))
        fail(path, ending(WTERMSIG(status)));
    if (WEXITSTATUS(status) == out_of_memory)
        fail(path, "ran out of memory, more than a file of its size needs");
    is_sound = WEXITSTATUS(status) == 0;
    if (WEXITSTATUS(status) != 0 && WEXITSTATUS(status) != refused)
        fail(path, join("ended with exit code ", WEXITSTATUS(status)));
}

} // namespace

bool was_sound_in_rehearsal()
{
    return is_sound;
}

void rehearse_if_wanted(const std::filesystem::path& path)
{
    is_sound = false;
    struct stat status = {};
    if (!is_wanted || stat(path.c_str(), &status) != 0)
        return;
    static std::mutex mutex;
    static std::map<Identity, bool> passed; // and whether they were sound
    const std::lock_guard lock(mutex);
    if (const auto known = passed.find(identity(status)); known != passed.end()) {
        is_sound = known->second;
        return;
    }
    rehearse_apart(path, static_cast<std::uint64_t>(status.st_size));
    passed.emplace(identity(status), is_sound);
}

} // namespace internal
} // namespace shape
