// SPDX-License-Identifier: MIT

#pragma once

#include <string_view>

namespace shape::tools {

/// Whether `a` stands before `b` as people order names: numbers by value (s2, s10; x_-1.5, x_-0.5,
/// x_0, x_2), everything else by character; equal ones by character alone.
///
/// A number is a run of digits with a decimal part if a point and a digit follow, and a sign before it
/// unless that follows a letter or digit (2020-01-05, s-3).
[[nodiscard]] bool natural_less(std::string_view a, std::string_view b);

} // namespace shape::tools
