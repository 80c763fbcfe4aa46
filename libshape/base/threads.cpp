// SPDX-License-Identifier: MIT

#include "libshape/base/threads.h"

#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <exception>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "libshape/base/error.h"
#include "libshape/base/format.h"

namespace shape {
using namespace internal;
namespace {

std::atomic<int>& configured_threads()
{
    static std::atomic<int> count{
        std::clamp(static_cast<int>(std::thread::hardware_concurrency()), 1, 1024)};
    return count;
}

/// Where a number of threads works.
struct Arena
{
    explicit Arena(int threads)
        : limit(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads)),
          arena(threads)
    {
    }
    tbb::global_control limit; // otherwise TBB stops at the number of processors
    tbb::task_arena arena;
};

/// Made anew after set_thread_count().
std::shared_ptr<Arena> arena_of_threads()
{
    static std::mutex mutex;
    static std::shared_ptr<Arena> current;
    const std::lock_guard lock(mutex);
    if (!current || current->arena.max_concurrency() != thread_count())
        current = std::make_shared<Arena>(thread_count());
    return current;
}

thread_local bool inside_loop = false; ///< This thread runs a chunk.

} // namespace

int thread_count()
{
    return configured_threads();
}

void set_thread_count(int count)
{
    if (count < 1 || count > 1024)
        throw InvalidInput(join("thread count is ", count, ", must be in [1, 1024]"));
    configured_threads() = count;
}

void parallel_for(std::size_t count, std::size_t grain,
                  const std::function<void(std::size_t, std::size_t)>& body)
{
    grain = std::max<std::size_t>(grain, 1);
    const std::size_t chunks = (count + grain - 1) / grain;
    const auto run = [&](std::size_t chunk) {
        body(chunk * grain, std::min(count, (chunk + 1) * grain));
    };
    if (chunks <= 1 || thread_count() == 1 || inside_loop) {
        for (std::size_t chunk = 0; chunk < chunks; ++chunk)
            run(chunk);
        return;
    }
    std::vector<std::exception_ptr> errors(chunks);
    const auto guarded = [&](std::size_t chunk) {
        inside_loop = true;
        try {
            run(chunk);
        } catch (...) {
            errors[chunk] = std::current_exception();
        }
        inside_loop = false;
    };
    // The caller does what no other thread takes, so a busy machine costs no waiting; but no chunk of
    // another loop, which might wait for what the caller holds.
    arena_of_threads()->arena.execute([&] {
        tbb::this_task_arena::isolate(
            [&] { tbb::parallel_for(std::size_t{0}, chunks, guarded, tbb::simple_partitioner{}); });
    });
    for (const std::exception_ptr& error : errors)
        if (error)
            std::rethrow_exception(error);
}

double parallel_sum(std::size_t count, std::size_t grain,
                    const std::function<double(std::size_t, std::size_t)>& term)
{
    grain = std::max<std::size_t>(grain, 1);
    std::vector<double> parts((count + grain - 1) / grain, 0.0);
    parallel_for(count, grain, [&](std::size_t begin, std::size_t end) {
        parts[begin / grain] = term(begin, end);
    });
    double sum = 0.0;
    for (double part : parts)
        sum += part;
    return sum;
}

} // namespace shape
