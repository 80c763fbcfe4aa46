// SPDX-License-Identifier: MIT

#pragma once

namespace shape::internal {

/// Three numbers of any kind: double, float, or eight floats in SIMD lanes (linalg/eight_lanes.h). One
/// formula then serves every kernel. The order of operations is fixed, so results are the same bits
/// wherever the formula stands; Eigen's depends on what it vectorises.
template <class Number>
struct Vector3
{
    Number x, y, z;
};

/// The vector of three consecutive numbers.
template <class Number>
[[gnu::always_inline]] inline Vector3<Number> vector3(const Number* numbers)
{
    return {numbers[0], numbers[1], numbers[2]};
}
template <class Number>
[[gnu::always_inline]] inline void store(const Vector3<Number>& vector, Number* numbers)
{
    numbers[0] = vector.x;
    numbers[1] = vector.y;
    numbers[2] = vector.z;
}

template <class Number>
[[gnu::always_inline]] inline Vector3<Number> operator+(const Vector3<Number>& a,
                                                        const Vector3<Number>& b)
{
    return {a.x + b.x, a.y + b.y, a.z + b.z};
}
template <class Number>
[[gnu::always_inline]] inline Vector3<Number> operator-(const Vector3<Number>& a,
                                                        const Vector3<Number>& b)
{
    return {a.x - b.x, a.y - b.y, a.z - b.z};
}
template <class Scale, class Number>
requires requires(const Scale& s, const Number& a)
{
    Number{s * a};
}
[[gnu::always_inline]] inline Vector3<Number> operator*(const Scale& s, const Vector3<Number>& a)
{
    return {s * a.x, s * a.y, s * a.z};
}
template <class Number>
[[gnu::always_inline]] inline Number dot(const Vector3<Number>& a, const Vector3<Number>& b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class Number>
[[gnu::always_inline]] inline Vector3<Number> cross(const Vector3<Number>& a,
                                                    const Vector3<Number>& b)
{
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

} // namespace shape::internal
