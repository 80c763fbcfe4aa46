// SPDX-License-Identifier: MIT

#include "libshape/base/memory_limit.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cstdlib>

namespace shape::internal {
namespace {

#if !defined(__SANITIZE_ADDRESS__) // which maps terabytes
/// In a process of its own: limits its address space to `more` beyond what it has, and checks.
[[noreturn]] void limited(std::uint64_t more)
{
    const std::uint64_t before = address_space();
    const rlimit limit{before + more, RLIM_INFINITY};
    if (before == 0 || setrlimit(RLIMIT_AS, &limit) != 0)
        _exit(2);
    const std::uint64_t left = address_space_left();
    _exit(is_memory_limited() && left <= more && left + (std::uint64_t{1} << 20) > more ? 0 : 1);
}

TEST(MemoryLimit, SaysHowMuchAddressSpaceIsLeft)
{
    EXPECT_GT(address_space(), std::uint64_t{1} << 20);
    EXPECT_EXIT(limited(std::uint64_t{64} << 20), testing::ExitedWithCode(0), "");
}
#endif

} // namespace
} // namespace shape::internal
