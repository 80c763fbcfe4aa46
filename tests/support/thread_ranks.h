// SPDX-License-Identifier: MIT

#pragma once

#include <algorithm>
#include <barrier>
#include <exception>
#include <functional>
#include <thread>
#include <vector>

#include "libshape/base/ranks.h"

namespace shape::test {

/// Runs body(ranks) in as many threads, each as one process of a run that is shared.
inline void run_as_ranks(int count, const std::function<void(const Ranks&)>& body)
{
    std::vector<std::span<double>> arrays(static_cast<std::size_t>(count));
    std::vector<std::exception_ptr> errors(arrays.size());
    std::barrier meeting(count);
    std::vector<std::thread> threads;
    for (int number = 0; number < count; ++number)
        threads.emplace_back([&, number] {
            const auto own = static_cast<std::size_t>(number);
            const auto combine = [&, number, own](std::span<double> numbers, const auto& with) {
                for (int bit = count / 2; bit > 0; bit /= 2) {
                    arrays[own] = numbers;
                    meeting.arrive_and_wait();
                    const std::span<double> other = arrays[static_cast<std::size_t>(number ^ bit)];
                    const std::vector<double> copy(other.begin(), other.end());
                    meeting.arrive_and_wait();
                    for (std::size_t i = 0; i < numbers.size(); ++i)
                        numbers[i] = with(numbers[i], copy[i]);
                }
            };
            Ranks ranks{number, count, 4, {}, {}};
            ranks.all_reduce_sum = [&](std::span<double> numbers) {
                combine(numbers, [](double a, double b) { return a + b; });
            };
            ranks.all_reduce_max = [&](std::span<double> numbers) {
                combine(numbers, [](double a, double b) { return std::max(a, b); });
            };
            try {
                body(ranks);
            } catch (...) {
                errors[own] = std::current_exception();
            }
        });
    for (std::thread& thread : threads)
        thread.join();
    for (const std::exception_ptr& error : errors)
        if (error)
            std::rethrow_exception(error);
}

} // namespace shape::test
