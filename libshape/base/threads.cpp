// SPDX-License-Identifier: MIT

#include "libshape/base/threads.h"

#include <omp.h>

#include <algorithm>
#include <atomic>
#include <exception>
#include <thread>
#include <vector>

#include "libshape/base/error.h"
#include "libshape/base/format.h"

namespace shape {
namespace {

std::atomic<int>& configured_threads()
{
    static std::atomic<int> count{
        std::clamp(static_cast<int>(std::thread::hardware_concurrency()), 1, 1024)};
    return count;
}

} // namespace

int thread_count() { return configured_threads(); }

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
    if (chunks <= 1 || thread_count() == 1 || omp_in_parallel()) {
        for (std::size_t chunk = 0; chunk < chunks; ++chunk)
            run(chunk);
        return;
    }
    std::vector<std::exception_ptr> errors(chunks);
#pragma omp parallel for schedule(dynamic) num_threads(thread_count())
    for (std::size_t chunk = 0; chunk < chunks; ++chunk) {
        try {
            run(chunk);
        } catch (...) {
            errors[chunk] = std::current_exception();
        }
    }
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
