// SPDX-License-Identifier: MIT

#include "libshape/io/scalar_type.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

namespace shape::internal {
namespace {

constexpr std::array<std::int64_t, 11> sizes = {1, 1, 2, 2, 4, 4, 8, 8, 2, 4, 8};

template <class Value>
Value stored(const char* bytes, bool swap)
{
    std::array<char, sizeof(Value)> copy;
    std::memcpy(copy.data(), bytes, sizeof(Value));
    if (swap)
        std::reverse(copy.begin(), copy.end());
    return std::bit_cast<Value>(copy);
}

/// The value of an IEEE 754 binary16: sign, 5 bits of exponent, 10 of mantissa.
double half_value(std::uint16_t bits)
{
    const int exponent = (bits >> 10) & 31;
    const int mantissa = bits & 1023;
    double value =
        std::ldexp(exponent == 0 ? mantissa : mantissa + 1024, std::max(exponent, 1) - 25);
    if (exponent == 31)
        value = mantissa == 0 ? std::numeric_limits<double>::infinity()
                              : std::numeric_limits<double>::quiet_NaN();
    return (bits >> 15) == 0 ? value : -value;
}

} // namespace

std::int64_t size_of(ScalarType type)
{
    return sizes[static_cast<std::size_t>(type)];
}

bool is_integer(ScalarType type)
{
    return type < ScalarType::Float16;
}

double number_at(const char* bytes, ScalarType type, bool swap)
{
    if (type == ScalarType::Float16)
        return half_value(stored<std::uint16_t>(bytes, swap));
    if (type == ScalarType::Float32)
        return stored<float>(bytes, swap);
    if (type == ScalarType::Float64)
        return stored<double>(bytes, swap);
    if (type == ScalarType::Uint64)
        return static_cast<double>(stored<std::uint64_t>(bytes, swap));
    return static_cast<double>(*integer_at(bytes, type, swap));
}

std::optional<std::int64_t> integer_at(const char* bytes, ScalarType type, bool swap)
{
    switch (type) {
        case ScalarType::Int8:
            return stored<std::int8_t>(bytes, swap);
        case ScalarType::Uint8:
            return stored<std::uint8_t>(bytes, swap);
        case ScalarType::Int16:
            return stored<std::int16_t>(bytes, swap);
        case ScalarType::Uint16:
            return stored<std::uint16_t>(bytes, swap);
        case ScalarType::Int32:
            return stored<std::int32_t>(bytes, swap);
        case ScalarType::Uint32:
            return stored<std::uint32_t>(bytes, swap);
        case ScalarType::Int64:
            return stored<std::int64_t>(bytes, swap);
        case ScalarType::Uint64: {
            const std::uint64_t value = unsigned_at(bytes, swap);
            if (value > static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max()))
                return std::nullopt;
            return static_cast<std::int64_t>(value);
        }
        default:
            return std::nullopt;
    }
}

std::uint64_t unsigned_at(const char* bytes, bool swap)
{
    return stored<std::uint64_t>(bytes, swap);
}

} // namespace shape::internal
