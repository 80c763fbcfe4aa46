// SPDX-License-Identifier: MIT

#pragma once

#include <string_view>

namespace shape::internal {

/// Deepest nesting of the JSON that is read: to print and to destroy a value takes a
/// stack frame a level, and a file may have as many as bytes.
inline constexpr int deepest_json = 64;

/// Whether no list or object lies deeper than that; says nothing else about the text. To be asked
/// before it is parsed.
[[nodiscard]] bool is_shallow_json(std::string_view text);

} // namespace shape::internal
