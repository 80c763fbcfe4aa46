// SPDX-License-Identifier: MIT

#pragma once

#include <cstdint>
#include <optional>

// The numbers that binary mesh files are made of. Internal to their readers.

namespace shape::internal {

enum class ScalarType
{
    Int8,
    Uint8,
    Int16,
    Uint16,
    Int32,
    Uint32,
    Int64,
    Uint64,
    Float16,
    Float32,
    Float64,
};

[[nodiscard]] std::int64_t size_of(ScalarType type); // [byte]
[[nodiscard]] bool is_integer(ScalarType type);

/// The value whose first byte is given.
/// @param swap  Whether the order of its bytes is not that of this machine.
[[nodiscard]] double number_at(const char* bytes, ScalarType type, bool swap);

/// The same of an integer type; none if it exceeds 63 bits, or if the type is not an integer's.
[[nodiscard]] std::optional<std::int64_t> integer_at(const char* bytes, ScalarType type, bool swap);

/// The 64 bits there as an unsigned integer, for messages of what exceeds 63.
[[nodiscard]] std::uint64_t unsigned_at(const char* bytes, bool swap);

} // namespace shape::internal
