// SPDX-License-Identifier: MIT

#pragma once

#include <cstddef>
#include <functional>

namespace shape {

/// Number of threads that parallel_for may use; the default is the number of processors.
[[nodiscard]] int thread_count();

/// Sets thread_count() for the whole process.
/// @throws InvalidInput if count < 1 or count > 1024.
void set_thread_count(int count);

/// Runs body(begin, end) over consecutive chunks that cover [0, count), of `grain` items (0 counts as 1; the last has fewer)
/// whatever the number of threads: a body that writes only to its own items, or to a slot of its own chunk (begin / grain), gives
/// the same bits with any thread count. Nested calls run in the calling thread.
/// If the body throws, the exception of the lowest chunk that threw is rethrown once no thread runs the body any more;
/// chunks after it may be left out.
/// @throws Interrupted if a stop was requested (progress.h): chunks that have not begun are left out.
void parallel_for(std::size_t count, std::size_t grain,
                  const std::function<void(std::size_t begin, std::size_t end)>& body);

/// Sum of term(begin, end) over the chunks of parallel_for, added in the order of the chunks.
[[nodiscard]] double parallel_sum(
    std::size_t count, std::size_t grain,
    const std::function<double(std::size_t begin, std::size_t end)>& term);

} // namespace shape
