// SPDX-License-Identifier: MIT

#pragma once

#include <cmath>
#include <vector>

namespace shape::internal {

/// A number of eight problems of the same structure that are solved in eight SIMD lanes: one vector
/// register with AVX2, and indices are read once for eight. Arithmetic is lane by lane; functions
/// that use it are to be SHAPE_VECTORISED (base/vectorised.h), free of branches in a lane. Not to be
/// passed by value: GCC (PR 84877) does not always align such copies.
struct alignas(32) EightLanes
{
    static constexpr int lanes = 8;
    float of[lanes];

    static constexpr EightLanes all(float value)
    {
        return {{value, value, value, value, value, value, value, value}};
    }
};

template <class Operation>
inline EightLanes lane_by_lane(const EightLanes& a, const EightLanes& b, Operation operation)
{
    EightLanes result;
    for (int k = 0; k < EightLanes::lanes; ++k)
        result.of[k] = operation(a.of[k], b.of[k]);
    return result;
}
inline EightLanes operator+(const EightLanes& a, const EightLanes& b)
{
    return lane_by_lane(a, b, [](float x, float y) { return x + y; });
}
inline EightLanes operator-(const EightLanes& a, const EightLanes& b)
{
    return lane_by_lane(a, b, [](float x, float y) { return x - y; });
}
inline EightLanes operator*(const EightLanes& a, const EightLanes& b)
{
    return lane_by_lane(a, b, [](float x, float y) { return x * y; });
}
inline EightLanes operator/(const EightLanes& a, const EightLanes& b)
{
    return lane_by_lane(a, b, [](float x, float y) { return x / y; });
}
inline EightLanes operator*(float a, const EightLanes& b)
{
    return lane_by_lane(b, b, [a](float x, float) { return a * x; });
}
inline EightLanes sqrt(const EightLanes& a)
{
    return lane_by_lane(a, a, [](float x, float) { return std::sqrt(x); });
}

/// A point or vector of eight problems.
struct EightLanePoint
{
    EightLanes x, y, z;
};

inline EightLanePoint operator+(const EightLanePoint& a, const EightLanePoint& b)
{
    return {a.x + b.x, a.y + b.y, a.z + b.z};
}
inline EightLanePoint operator-(const EightLanePoint& a, const EightLanePoint& b)
{
    return {a.x - b.x, a.y - b.y, a.z - b.z};
}
inline EightLanePoint operator*(const EightLanes& s, const EightLanePoint& a)
{
    return {s * a.x, s * a.y, s * a.z};
}
inline EightLanePoint operator*(float s, const EightLanePoint& a)
{
    return {s * a.x, s * a.y, s * a.z};
}
inline EightLanes dot(const EightLanePoint& a, const EightLanePoint& b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
inline EightLanePoint cross(const EightLanePoint& a, const EightLanePoint& b)
{
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/// One per vertex, face, ...
using EightLanePoints = std::vector<EightLanePoint>;

} // namespace shape::internal
