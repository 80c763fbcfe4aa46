// SPDX-License-Identifier: MIT

#pragma once

#include <functional>
#include <span>

namespace shape {

/// The processes that share a run, on one machine or several. All read the same input and go the same way,
/// each with its part of the meshes; what each has found is put together by these functions, which every
/// process calls at the same places with arrays of the same sizes. Same bits for every `count` with the same `partial_sums`.
struct Ranks
{
    int number = 0; ///< Of this process, in [0, count).
    int count = 1;  ///< A power of two, at most `partial_sums`.
    /// Number of partial sums over the meshes, a power of two, which are added as a tree: those of one process
    /// first, then over processes. 1 where processes are not in play: no array is held twice then.
    int partial_sums = 1;
    /// Adds the arrays of all processes, as a tree over the bits of their numbers, the highest first; all
    /// of them get the same sum.
    std::function<void(std::span<double> numbers)> all_reduce_sum = [](std::span<double>) {};
    /// The largest of each number instead.
    std::function<void(std::span<double> numbers)> all_reduce_max = [](std::span<double>) {};

    /// Whether this is the process that reports and writes what all have found.
    [[nodiscard]] bool is_root() const { return number == 0; }
};

/// @throws InvalidInput naming the first field that breaks its rule.
void check(const Ranks& ranks);

} // namespace shape
