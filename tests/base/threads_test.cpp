// SPDX-License-Identifier: MIT

#include "libshape/base/threads.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "libshape/base/error.h"
#include "libshape/base/stop.h"
#include "tests/support/thread_scope.h"

namespace shape {
namespace {

TEST(ParallelFor, VisitsEveryItemOnceInChunksOfTheGrain)
{
    for (const int threads : {1, 2, 3, 8}) {
        const test::ThreadScope scope(threads);
        for (const std::size_t count : {0u, 1u, 9u, 10u, 11u, 1000u})
            for (const std::size_t grain : {1u, 3u, 10u, 2000u}) {
                std::vector<std::atomic<int>> visits(count);
                parallel_for(count, grain, [&](std::size_t begin, std::size_t end) {
                    EXPECT_EQ(begin % grain, 0u);
                    EXPECT_EQ(end, std::min(count, begin + grain));
                    for (std::size_t i = begin; i < end; ++i)
                        ++visits[i];
                });
                for (const auto& visit : visits)
                    EXPECT_EQ(visit, 1);
            }
    }
}

TEST(ParallelFor, TakesAGrainOfZeroForOne)
{
    std::atomic<int> calls = 0;
    parallel_for(5, 0, [&](std::size_t begin, std::size_t end) {
        EXPECT_EQ(end, begin + 1);
        ++calls;
    });
    EXPECT_EQ(calls, 5);
}

TEST(ParallelFor, StopsBetweenChunksWhenAsked)
{
    using namespace internal;
    for (const int threads : {1, 2, 4}) {
        const test::ThreadScope scope(threads);
        std::atomic<bool> is_requested = false;
        const StopScope heed(&is_requested);
        std::atomic<int> begun = 0;
        const auto work = [&](std::size_t, std::size_t) {
            ++begun;
            is_requested = true;
        };
        EXPECT_THROW(parallel_for(100'000, 1, work), Interrupted);
        EXPECT_GE(begun, 1);
        EXPECT_LE(begun, threads);
        begun = 0;
        EXPECT_THROW(parallel_for(1, 1, work), Interrupted); // asked for already
        EXPECT_EQ(begun, 0);
    }
    std::atomic<int> visits = 0; // the scopes are gone
    parallel_for(8, 1, [&](std::size_t, std::size_t) { ++visits; });
    EXPECT_EQ(visits, 8);
}

TEST(ParallelFor, HelpersHeedTheStopOfTheirCaller)
{
    const test::ThreadScope scope(2);
    std::atomic<bool> is_requested = true;
    std::atomic<int> heeding = 0;
    std::atomic<int> arrived = 0;
    {
        std::atomic<bool> is_not = false;
        const internal::StopScope heed(&is_not);
        parallel_for(2, 1, [&](std::size_t, std::size_t) {
            ++arrived;
            while (arrived < 2)
                std::this_thread::yield();
            heeding += internal::stop_request == &is_not ? 1 : 0;
        });
    }
    EXPECT_EQ(heeding, 2);
    const internal::StopScope heed(&is_requested);
    EXPECT_THROW(internal::throw_if_stop_requested(), Interrupted);
}

#if !defined(__SANITIZE_THREAD__) // which lets no child of several threads start one

/// Two chunks that end only if two threads run them.
void meet()
{
    std::atomic<int> arrived = 0;
    parallel_for(2, 1, [&](std::size_t, std::size_t) {
        ++arrived;
        while (arrived < 2)
            std::this_thread::yield();
    });
}

TEST(ParallelFor, GoesOnInTheChildOfAFork)
{
    const test::ThreadScope scope(2);
    meet(); // there are helpers now, which the child will not have
    for (int round = 0; round < 20; ++round) {
        const pid_t child = fork();
        if (child == 0) {
            alarm(20);
            meet();
            _exit(0);
        }
        int status = 0;
        ASSERT_EQ(waitpid(child, &status, 0), child);
        ASSERT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << "round " << round;
        meet(); // and so do we
    }
}

TEST(ParallelFor, ForksWhileOtherThreadsRunLoops)
{
    const test::ThreadScope scope(3);
    std::atomic<bool> is_over = false;
    std::thread busy([&] {
        while (!is_over)
            parallel_for(64, 1, [](std::size_t, std::size_t) {});
    });
    for (int round = 0; round < 50; ++round) {
        const pid_t child = fork();
        if (child == 0) {
            alarm(20);
            parallel_for(64, 1, [](std::size_t, std::size_t) {});
            _exit(0);
        }
        int status = 0;
        EXPECT_EQ(waitpid(child, &status, 0), child);
        EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << "round " << round;
    }
    is_over = true;
    busy.join();
}

#endif

TEST(ParallelFor, UsesSeveralThreads)
{
    const test::ThreadScope scope(2);
    // Each chunk waits for the other one: this ends only if both run at the same time.
    std::atomic<int> arrived = 0;
    parallel_for(2, 1, [&](std::size_t, std::size_t) {
        ++arrived;
        while (arrived < 2) {
        }
    });
    EXPECT_EQ(arrived, 2);
}

TEST(ParallelFor, BeginsWithTheSameShareInEveryLoop)
{
    const test::ThreadScope scope(2);
    const auto caller = std::this_thread::get_id();
    for (int loop = 0; loop < 100; ++loop) {
        std::atomic<int> first_of_helper = -1;
        parallel_for(8, 1, [&](std::size_t begin, std::size_t) {
            int none = -1;
            if (std::this_thread::get_id() != caller)
                first_of_helper.compare_exchange_strong(none, static_cast<int>(begin));
            else
                while (first_of_helper < 0) {
                }
        });
        ASSERT_EQ(first_of_helper, 4); // the caller has 0 to 3
    }
}

TEST(ParallelFor, RethrowsTheErrorOfTheLowestChunkAfterAllHaveEnded)
{
    const test::ThreadScope scope(4);
    std::atomic<int> ended = 0;
    try {
        parallel_for(64, 1, [&](std::size_t begin, std::size_t) {
            ++ended;
            if (begin % 10 == 7)
                throw InvalidInput(std::to_string(begin));
        });
        FAIL() << "nothing was thrown";
    } catch (const InvalidInput& error) {
        EXPECT_STREQ(error.what(), "7");
    }
    EXPECT_EQ(ended, 64);
}

TEST(ParallelFor, RunsNestedCalls)
{
    const test::ThreadScope scope(3);
    std::vector<std::atomic<int>> visits(60);
    parallel_for(6, 1, [&](std::size_t outer, std::size_t) {
        parallel_for(10, 2, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i)
                ++visits[10 * outer + i];
        });
    });
    for (const auto& visit : visits)
        EXPECT_EQ(visit, 1);
}

TEST(ParallelFor, RunsLoopsOfSeveralThreadsAtOnce)
{
    const test::ThreadScope scope(3);
    constexpr std::size_t callers = 4;
    constexpr std::size_t rounds = 200;
    constexpr std::size_t items = 50;
    std::vector<std::atomic<std::size_t>> visits(callers * items);
    std::vector<std::thread> threads;
    for (std::size_t caller = 0; caller < callers; ++caller)
        threads.emplace_back([&visits, caller] {
            for (std::size_t round = 0; round < rounds; ++round)
                parallel_for(items, 4, [&](std::size_t begin, std::size_t end) {
                    for (std::size_t i = begin; i < end; ++i)
                        ++visits[caller * items + i];
                });
        });
    for (std::thread& thread : threads)
        thread.join();
    for (const auto& visit : visits)
        EXPECT_EQ(visit, rounds);
}

#if !defined(__SANITIZE_ADDRESS__) // which maps terabytes
/// Leaves no room for the stack of another thread.
void forbid_threads()
{
    std::uint64_t pages = 0;
    std::ifstream("/proc/self/statm") >> pages;
    const rlimit limit{pages * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE)) + (1 << 20),
                       RLIM_INFINITY};
    setrlimit(RLIMIT_AS, &limit);
}

TEST(ParallelForDeathTest, WorksWhereNoThreadCanBeStarted)
{
    testing::FLAGS_gtest_death_test_style = "threadsafe";
    EXPECT_EXIT(
        {
            set_thread_count(64);
            forbid_threads();
            std::atomic<int> visits = 0;
            for (int round = 0; round < 3; ++round)
                parallel_for(100, 1, [&](std::size_t, std::size_t) { ++visits; });
            std::exit(visits == 300 ? 0 : 1);
        },
        testing::ExitedWithCode(0), "");
}
#endif

TEST(ParallelFor, WorksOnAfterAPauseAndWithAnotherNumberOfThreads)
{
    for (const int threads : {2, 5, 1, 3}) {
        const test::ThreadScope scope(threads);
        for (int round = 0; round < 3; ++round) {
            std::atomic<std::size_t> visits = 0;
            parallel_for(100, 3,
                         [&](std::size_t begin, std::size_t end) { visits += end - begin; });
            EXPECT_EQ(visits, 100u);
            std::this_thread::sleep_for(std::chrono::milliseconds(2)); // helpers fall asleep
        }
    }
}

TEST(ParallelSum, HasTheSameBitsForAnyThreadCount)
{
    const auto sum = [](int threads) {
        const test::ThreadScope scope(threads);
        return parallel_sum(100000, 1000, [](std::size_t begin, std::size_t end) {
            double part = 0.0;
            for (std::size_t i = begin; i < end; ++i)
                part += 1.0 / (1.0 + static_cast<double>(i));
            return part;
        });
    };
    // Harmonic number: ln n + gamma + 1/(2n) - 1/(12 n^2).
    EXPECT_NEAR(sum(1), std::log(1e5) + 0.57721566490153286 + 5e-6 - 1.0 / 12e10, 1e-12);
    for (const int threads : {2, 3, 7})
        EXPECT_EQ(sum(threads), sum(1));
}

TEST(ThreadCount, RefusesWhatIsOutOfItsRangeAndKeepsWhatWas)
{
    const test::ThreadScope scope(3);
    for (const int count : {-1, 0, 1025})
        EXPECT_THROW(set_thread_count(count), InvalidInput);
    EXPECT_EQ(thread_count(), 3);
    set_thread_count(1024);
    EXPECT_EQ(thread_count(), 1024);
}

} // namespace
} // namespace shape
