// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

#include "libshape/base/to_size.h"
#include "libshape/mesh/points.h"

namespace shape::internal {

using Triangle = std::array<Eigen::Vector3f, 3>;

/// The corners of a face.
inline Triangle corners_of(const Faces& faces, Eigen::Index face,
                           const std::vector<Eigen::Vector3f>& points)
{
    const auto corner = [&](int c) { return points[to_size(faces(face, c))]; };
    return {corner(0), corner(1), corner(2)};
}

/// Rows of samples, from the upper edge of an image.
struct Rows
{
    int begin = 0;
    int end = 0;
};

/// Calls hit(x, y, weights) for every sample in these rows whose centre lies in the triangle.
/// @param corners  x and y in samples, y downwards; z is not looked at.
/// @param weights  Barycentric, of the centre.
template <class Hit>
void rasterise(const Triangle& corners, int width, Rows rows, const Hit& hit)
{
    const auto& [a, b, c] = corners;
    const float area = (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
    if (area == 0.0F)
        return;
    const auto first = [](float value, int begin) {
        return std::max(begin, static_cast<int>(std::ceil(value - 0.5F)));
    };
    const auto last = [](float value, int end) {
        return std::min(end - 1, static_cast<int>(std::floor(value - 0.5F)));
    };
    const int x0 = first(std::min({a.x(), b.x(), c.x()}), 0);
    const int x1 = last(std::max({a.x(), b.x(), c.x()}), width);
    const int y0 = first(std::min({a.y(), b.y(), c.y()}), rows.begin);
    const int y1 = last(std::max({a.y(), b.y(), c.y()}), rows.end);
    const float scale = 1.0F / area;
    for (int y = y0; y <= y1; ++y)
        for (int x = x0; x <= x1; ++x) {
            const float px = static_cast<float>(x) + 0.5F;
            const float py = static_cast<float>(y) + 0.5F;
            const float v =
                scale * ((px - a.x()) * (c.y() - a.y()) - (py - a.y()) * (c.x() - a.x()));
            const float w =
                scale * ((b.x() - a.x()) * (py - a.y()) - (b.y() - a.y()) * (px - a.x()));
            const float u = 1.0F - v - w;
            if (u >= 0.0F && v >= 0.0F && w >= 0.0F)
                hit(x, y, Eigen::Vector3f(u, v, w));
        }
}

} // namespace shape::internal
