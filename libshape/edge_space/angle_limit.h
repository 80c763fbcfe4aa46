// SPDX-License-Identifier: MIT

#pragma once

#include <cmath>

namespace shape::internal {

/// Dihedral angles of targets lie within this [rad]: of larger ones the sine is mostly rounding, and beyond
/// 1e16 nothing else.
inline constexpr double angle_limit = 1e9;

[[nodiscard]] inline bool is_within_angle_limit(double angle) // false for NaN
{
    return std::abs(angle) <= angle_limit;
}

} // namespace shape::internal
