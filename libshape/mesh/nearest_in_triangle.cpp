// SPDX-License-Identifier: MIT

#include "libshape/mesh/nearest_in_triangle.h"

#include <algorithm>

namespace shape::internal {

using Eigen::Vector3d;

Vector3d nearest_in_triangle(const Vector3d& p, const Vector3d& a, const Vector3d& b,
                             const Vector3d& c)
{
    const Vector3d ab = b - a, ac = c - a, ap = p - a;
    const double d1 = ab.dot(ap), d2 = ac.dot(ap);
    if (d1 <= 0.0 && d2 <= 0.0)
        return {1.0, 0.0, 0.0};
    const Vector3d bp = p - b;
    const double d3 = ab.dot(bp), d4 = ac.dot(bp);
    if (d3 >= 0.0 && d4 <= d3)
        return {0.0, 1.0, 0.0};
    const Vector3d cp = p - c;
    const double d5 = ab.dot(cp), d6 = ac.dot(cp);
    if (d6 >= 0.0 && d5 <= d6)
        return {0.0, 0.0, 1.0};
    const double of_c = d1 * d4 - d3 * d2;
    const double of_b = d5 * d2 - d1 * d6;
    const double of_a = d3 * d6 - d5 * d4;
    const double area = of_a + of_b + of_c;
    const auto on_side = [](double along, double rest) {
        return along + rest > 0.0 ? along / (along + rest) : 0.0;
    };
    // area is (|ab| |ac| sin)^2; of a sliver of 1e-7 rad only rounding is left of it.
    if (area > 1e-14 * ab.squaredNorm() * ac.squaredNorm() && of_a >= 0.0 && of_b >= 0.0 &&
        of_c >= 0.0)
        return {of_a / area, of_b / area, of_c / area};
    // Beyond a side, or no area: the best of the three sides.
    const double t_ab = std::clamp(on_side(d1, -d3), 0.0, 1.0);
    const double t_ac = std::clamp(on_side(d2, -d6), 0.0, 1.0);
    const double t_bc = std::clamp(on_side(d4 - d3, d5 - d6), 0.0, 1.0);
    const double e_ab = (ap - t_ab * ab).squaredNorm();
    const double e_ac = (ap - t_ac * ac).squaredNorm();
    const double e_bc = (bp - t_bc * (c - b)).squaredNorm();
    if (e_ab <= e_ac && e_ab <= e_bc)
        return {1.0 - t_ab, t_ab, 0.0};
    if (e_ac <= e_bc)
        return {1.0 - t_ac, 0.0, t_ac};
    return {0.0, 1.0 - t_bc, t_bc};
}

} // namespace shape::internal
