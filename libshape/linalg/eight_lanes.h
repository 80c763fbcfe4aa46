// SPDX-License-Identifier: MIT

#pragma once

#include <cmath>
#include <vector>

#include "libshape/base/vector3.h"

namespace shape::internal {

/// A number of eight problems of the same structure that are solved in eight SIMD lanes: one vector
/// register with AVX2, and indices are read once for eight. Arithmetic is lane by lane; functions
/// that use it are to be SHAPE_VECTORISED (base/vectorised.h), free of branches in a lane. Not to be
/// passed by value: GCC (PR 84877) does not always align such copies.
struct alignas(32) EightLanes
{
    using Scalar = float;
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
inline EightLanes operator+(float a, const EightLanes& b)
{
    return lane_by_lane(b, b, [a](float x, float) { return a + x; });
}
inline EightLanes operator+(const EightLanes& a, float b)
{
    return lane_by_lane(a, a, [b](float x, float) { return x + b; });
}
inline EightLanes operator-(const EightLanes& a, float b)
{
    return lane_by_lane(a, a, [b](float x, float) { return x - b; });
}
inline EightLanes operator-(const EightLanes& a)
{
    return lane_by_lane(a, a, [](float x, float) { return -x; });
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
using EightLanePoint = Vector3<EightLanes>;

/// One per vertex, face, ...
using EightLanePoints = std::vector<EightLanePoint>;

} // namespace shape::internal
