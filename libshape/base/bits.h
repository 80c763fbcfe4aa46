// SPDX-License-Identifier: MIT

#pragma once

#include <cstdint>
#include <cstring>

namespace shape::internal {

/// The bits of a float, and the float of some bits: std::bit_cast for the standard library of emscripten 3.1.6, which lacks it.
[[nodiscard]] inline std::uint32_t bits_of(float value)
{
    std::uint32_t bits = 0;
    std::memcpy(&bits, &value, sizeof bits);
    return bits;
}
[[nodiscard]] inline float float_of(std::uint32_t bits)
{
    float value = 0.0F;
    std::memcpy(&value, &bits, sizeof value);
    return value;
}

} // namespace shape::internal
