// SPDX-License-Identifier: MIT

#pragma once

#include <cstdint>

namespace shape::internal {

/// Seeded random numbers with the same bits on every platform and standard library
/// (the distributions of <random> are not portable). SplitMix64 (Steele, Lea, Flood 2014).
class Random
{
public:
    explicit Random(std::uint64_t seed) : state_(seed) {}

    /// Uniform in [0, 2^64).
    [[nodiscard]] std::uint64_t bits();

    /// Uniform in [0, 1).
    [[nodiscard]] double uniform();

    /// Uniform in [low, high).
    [[nodiscard]] double uniform(double low, double high);

    /// Standard normal (Box and Muller, one of the pair; independent calls).
    [[nodiscard]] double normal();

    /// Uniform in {0, ..., count - 1}; count > 0.
    [[nodiscard]] std::uint64_t index(std::uint64_t count);

private:
    std::uint64_t state_;
};

} // namespace shape::internal
