// SPDX-License-Identifier: MIT

#include "libshape/base/memory_limit.h"

#include <sys/resource.h>
#include <unistd.h>

#include <fstream>
#include <limits>

namespace shape::internal {
namespace {

/// The largest value if there is none.
std::uint64_t limit_of(__rlimit_resource resource)
{
    rlimit limit{};
    const bool is_known = getrlimit(resource, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY;
    return is_known ? limit.rlim_cur : std::numeric_limits<std::uint64_t>::max();
}

} // namespace

bool is_memory_limited()
{
    constexpr std::uint64_t none = std::numeric_limits<std::uint64_t>::max();
    return limit_of(RLIMIT_AS) != none || limit_of(RLIMIT_DATA) != none;
}

std::uint64_t address_space()
{
    std::uint64_t pages = 0;
    std::ifstream("/proc/self/statm") >> pages;
    return pages * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
}

std::uint64_t address_space_left()
{
    const std::uint64_t limit = limit_of(RLIMIT_AS);
    const std::uint64_t used = address_space();
    return limit > used ? limit - used : 0;
}

} // namespace shape::internal
