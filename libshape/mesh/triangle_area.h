// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace shape::internal {

/// 16 A^2 of the triangle with these sides [length^4] (Heron): < 0 where a side is longer than the
/// two others together, 0 where it is as long.
///
/// Rounding never turns the sign, but may make it 0, and changes a value by at most 4e-16 P / s of
/// it: P the perimeter, s by how much the longest side is shorter than the two others together.
/// @param a, b, c  [length], > 0, within [1e-75, 1e75] so that nothing under- or overflows.
[[nodiscard]] constexpr double sixteen_squared_areas(double a, double b, double c)
{
    return (a + b + c) * (b + c - a) * (c + a - b) * (a + b - c);
}

/// Area of the triangle with these corners [length^2]; rows or columns of three.
template <class Vector>
[[nodiscard]] double triangle_area(const Vector& a, const Vector& b, const Vector& c)
{
    return 0.5 * (b - a).cross(c - a).norm();
}

} // namespace shape::internal
