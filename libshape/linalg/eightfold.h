// SPDX-License-Identifier: MIT

#pragma once

#include <cmath>
#include <vector>

namespace shape {

/// A number of eight problems of the same structure that are solved in lock-step: one vector
/// register with AVX2, and indices are read once for eight. Arithmetic is lane by lane; functions
/// that use it are to be SHAPE_VECTORISED (base/vectorised.h), free of branches in a lane. Not to be
/// passed by value: GCC (PR 84877) does not always align such copies.
struct alignas(32) Eightfold
{
    static constexpr int lanes = 8;
    float of[lanes];

    static constexpr Eightfold all(float value)
    {
        return {{value, value, value, value, value, value, value, value}};
    }
};

template <class Operation>
inline Eightfold lane_by_lane(const Eightfold& a, const Eightfold& b, Operation operation)
{
    Eightfold result;
    for (int k = 0; k < Eightfold::lanes; ++k)
        result.of[k] = operation(a.of[k], b.of[k]);
    return result;
}
inline Eightfold operator+(const Eightfold& a, const Eightfold& b)
{
    return lane_by_lane(a, b, [](float x, float y) { return x + y; });
}
inline Eightfold operator-(const Eightfold& a, const Eightfold& b)
{
    return lane_by_lane(a, b, [](float x, float y) { return x - y; });
}
inline Eightfold operator*(const Eightfold& a, const Eightfold& b)
{
    return lane_by_lane(a, b, [](float x, float y) { return x * y; });
}
inline Eightfold operator/(const Eightfold& a, const Eightfold& b)
{
    return lane_by_lane(a, b, [](float x, float y) { return x / y; });
}
inline Eightfold operator*(float a, const Eightfold& b)
{
    return lane_by_lane(b, b, [a](float x, float) { return a * x; });
}
inline Eightfold sqrt(const Eightfold& a)
{
    return lane_by_lane(a, a, [](float x, float) { return std::sqrt(x); });
}

/// A point or vector of eight problems.
struct EightfoldPoint
{
    Eightfold x, y, z;
};

inline EightfoldPoint operator+(const EightfoldPoint& a, const EightfoldPoint& b)
{
    return {a.x + b.x, a.y + b.y, a.z + b.z};
}
inline EightfoldPoint operator-(const EightfoldPoint& a, const EightfoldPoint& b)
{
    return {a.x - b.x, a.y - b.y, a.z - b.z};
}
inline EightfoldPoint operator*(const Eightfold& s, const EightfoldPoint& a)
{
    return {s * a.x, s * a.y, s * a.z};
}
inline EightfoldPoint operator*(float s, const EightfoldPoint& a)
{
    return {s * a.x, s * a.y, s * a.z};
}
inline Eightfold dot(const EightfoldPoint& a, const EightfoldPoint& b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
inline EightfoldPoint cross(const EightfoldPoint& a, const EightfoldPoint& b)
{
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/// One per vertex, face, ...
using EightfoldPoints = std::vector<EightfoldPoint>;

} // namespace shape
