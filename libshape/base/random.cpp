// SPDX-License-Identifier: MIT

#include "libshape/base/random.h"

#include <cmath>
#include <numbers>

namespace shape::internal {
namespace {

__extension__ using Wide = unsigned __int128; // no warning about what is not ISO C++

} // namespace

std::uint64_t Random::bits()
{
    state_ += 0x9e3779b97f4a7c15ULL;
    std::uint64_t z = state_;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
    return z ^ (z >> 31);
}

double Random::uniform()
{
    return static_cast<double>(bits() >> 11) * 0x1.0p-53;
}

double Random::uniform(double low, double high)
{
    return low + (high - low) * uniform();
}

double Random::normal()
{
    const double radius = std::sqrt(-2.0 * std::log1p(-uniform()));
    return radius * std::cos(2.0 * std::numbers::pi * uniform());
}

std::uint64_t Random::index(std::uint64_t count)
{
    // Multiply-shift; the bias is below 2^-64 * count.
    return static_cast<std::uint64_t>((static_cast<Wide>(bits()) * count) >> 64);
}

} // namespace shape::internal
