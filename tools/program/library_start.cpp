// SPDX-License-Identifier: MIT

#include "tools/program/library_start.h"

#include <unistd.h>

#include <cstdlib>
#include <exception>
#include <new>
#include <string_view>

#ifdef __linux__
#include <sched.h>
#endif

namespace shape::tools {

#ifdef __linux__
namespace {

/// Of exceptions that nobody catches: those of libraries that start where there is no memory.
[[noreturn]] void end_in_a_line()
{
    try {
        if (std::current_exception())
            throw;
    } catch (const std::bad_alloc&) {
        constexpr std::string_view line = "shape: error: out of memory\n";
        (void)!write(STDERR_FILENO, line.data(), line.size());
        _exit(6); // over a limit, as main() has it
    } catch (...) {
    }
    std::abort();
}

cpu_set_t processors; ///< Those of the process.
bool are_known = false;

/// Runs before any library starts, that of the sanitizers too.
__attribute__((no_sanitize("address", "undefined"))) void show_one_processor(int, char**, char**)
{
    std::set_terminate(end_in_a_line);
    are_known = sched_getaffinity(0, sizeof processors, &processors) == 0;
    if (!are_known)
        return;
    static cpu_set_t first;
    for (int i = 0; i < CPU_SETSIZE && CPU_COUNT(&first) == 0; ++i)
        if (CPU_ISSET(i, &processors))
            CPU_SET(i, &first);
    sched_setaffinity(0, sizeof first, &first);
}

__attribute__((section(".preinit_array"),
               used)) void (*const before_libraries)(int, char**, char**) = show_one_processor;

} // namespace

void use_all_processors()
{
    if (are_known)
        sched_setaffinity(0, sizeof processors, &processors);
}
#else
void use_all_processors() {}
#endif

} // namespace shape::tools
