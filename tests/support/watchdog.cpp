// SPDX-License-Identifier: MIT

#include <gtest/gtest.h>

#if defined(__GLIBC__)
#include <execinfo.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <string_view>

namespace shape::test {
namespace {

/// Shorter than the time after which ctest kills a test (CMakePresets.json): a test that hangs says where first.
constexpr unsigned longest_test = 580; // [s]

void print_stack(int /*signal*/)
{
    std::array<void*, 64> frames;
    constexpr std::string_view title = "This test hangs; the stack of its first thread:\n";
    (void)!write(STDERR_FILENO, title.data(), title.size());
    backtrace_symbols_fd(frames.data(), backtrace(frames.data(), frames.size()), STDERR_FILENO);
}

/// Of every test: an alarm, which goes off when it takes too long.
class Watchdog : public testing::EmptyTestEventListener
{
    void OnTestStart(const testing::TestInfo& /*test*/) override
    {
        std::array<void*, 1> frame;
        (void)backtrace(frame.data(), frame.size()); // loads what it needs while nothing hangs
        std::signal(SIGALRM, print_stack);
        alarm(longest_test);
    }
    void OnTestEnd(const testing::TestInfo& /*test*/) override { alarm(0); }
};

[[maybe_unused]] const bool is_watched = [] {
    testing::UnitTest::GetInstance()->listeners().Append(new Watchdog);
    return true;
}();

} // namespace
} // namespace shape::test
#endif
