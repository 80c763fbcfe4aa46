// SPDX-License-Identifier: MIT

#include "libshape/edge_space/mean_value_coordinates.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "libshape/base/error.h"
#include "libshape/base/format.h"

namespace shape {
using namespace internal;
namespace {

using Eigen::Index;
using Eigen::Vector2d;

constexpr double on_the_boundary = 1e-12; // relative to the extent

double cross(const Vector2d& a, const Vector2d& b)
{
    return a.x() * b.y() - a.y() * b.x();
}

Vector2d corner(const Polygon& polygon, Index i)
{
    return polygon.row(i % polygon.rows()).transpose();
}

double extent(const Polygon& polygon)
{
    return (polygon.colwise().maxCoeff() - polygon.colwise().minCoeff()).norm();
}

/// The point of the segment from a to b that is nearest to p, as its share of the way.
double nearest_share(const Vector2d& a, const Vector2d& b, const Vector2d& p)
{
    const Vector2d way = b - a;
    return std::clamp((p - a).dot(way) / way.squaredNorm(), 0.0, 1.0);
}

double distance_to_segment(const Vector2d& a, const Vector2d& b, const Vector2d& p)
{
    return (a + nearest_share(a, b, p) * (b - a) - p).norm();
}

bool segments_touch(const Vector2d& a, const Vector2d& b, const Vector2d& c, const Vector2d& d)
{
    const auto side = [](const Vector2d& p, const Vector2d& q, const Vector2d& r) {
        const double area = cross(q - p, r - p);
        return area > 0.0 ? 1 : area < 0.0 ? -1 : 0;
    };
    if (side(a, b, c) * side(a, b, d) < 0 && side(c, d, a) * side(c, d, b) < 0)
        return true;
    return distance_to_segment(a, b, c) == 0.0 || distance_to_segment(a, b, d) == 0.0 ||
           distance_to_segment(c, d, a) == 0.0 || distance_to_segment(c, d, b) == 0.0;
}

/// Whether the polygon winds around a point off its boundary.
bool is_inside(const Polygon& polygon, const Vector2d& point)
{
    bool inside = false;
    for (Index i = 0; i < polygon.rows(); ++i) {
        const Vector2d a = corner(polygon, i) - point;
        const Vector2d b = corner(polygon, i + 1) - point;
        if ((a.y() > 0.0) != (b.y() > 0.0) && (cross(a, b) > 0.0) == (b.y() > a.y()))
            inside = !inside;
    }
    return inside;
}

/// tan(angle / 2) of the angle from a to b in (-pi, pi), without cancellation at either end.
double half_tangent(const Vector2d& a, const Vector2d& b)
{
    const double sine = cross(a, b);
    const double cosine = a.dot(b);
    const double product = a.norm() * b.norm();
    return cosine >= 0.0 ? sine / (product + cosine) : (product - cosine) / sine;
}

} // namespace

void check_simple_polygon(const Polygon& polygon)
{
    const Index n = polygon.rows();
    if (n < 3)
        throw InvalidInput(join("the polygon has ", n, " corners, must have at least 3"));
    if (!polygon.allFinite())
        throw InvalidInput("the polygon has a corner that is not finite");
    for (Index i = 0; i < n; ++i)
        for (Index j = i + 1; j < n; ++j) {
            const Vector2d a = corner(polygon, i);
            const Vector2d b = corner(polygon, i + 1);
            const Vector2d c = corner(polygon, j);
            const Vector2d d = corner(polygon, j + 1);
            if (a == c)
                throw InvalidInput(join("the polygon is not simple: corners ", i + 1, " and ",
                                        j + 1, " are the same"));
            const bool follows = j == i + 1;
            const bool precedes = (j + 1) % n == i;
            const bool touch =
                follows ? distance_to_segment(a, b, d) == 0.0 || distance_to_segment(c, d, a) == 0.0
                : precedes
                    ? distance_to_segment(a, b, c) == 0.0 || distance_to_segment(c, d, b) == 0.0
                    : segments_touch(a, b, c, d);
            if (touch)
                throw InvalidInput(join("the polygon is not simple: the edges that leave corners ",
                                        i + 1, " and ", j + 1, " touch"));
        }
}

Eigen::VectorXd mean_value_coordinates(const Polygon& polygon, const Vector2d& point)
{
    check_simple_polygon(polygon);
    const Index n = polygon.rows();
    const double tolerance = on_the_boundary * extent(polygon);
    Eigen::VectorXd weights = Eigen::VectorXd::Zero(n);
    for (Index i = 0; i < n; ++i)
        if ((corner(polygon, i) - point).norm() <= tolerance) {
            weights[i] = 1.0;
            return weights;
        }
    for (Index i = 0; i < n; ++i) {
        const Vector2d a = corner(polygon, i);
        const Vector2d b = corner(polygon, i + 1);
        if (distance_to_segment(a, b, point) <= tolerance) {
            const double share = nearest_share(a, b, point);
            weights[i] = 1.0 - share;
            weights[(i + 1) % n] = share;
            return weights;
        }
    }
    if (!point.allFinite() || !is_inside(polygon, point))
        throw InvalidInput(
            join("the point (", point.x(), ", ", point.y(), ") lies outside the polygon"));
    // Hormann and Floater 2006, eq. 11.
    Eigen::VectorXd tangents(n);
    for (Index i = 0; i < n; ++i)
        tangents[i] = half_tangent(corner(polygon, i) - point, corner(polygon, i + 1) - point);
    for (Index i = 0; i < n; ++i)
        weights[i] =
            (tangents[(i + n - 1) % n] + tangents[i]) / (corner(polygon, i) - point).norm();
    return weights / weights.sum();
}

Polygon regular_polygon(int corners)
{
    if (corners < 3)
        throw InvalidInput(join("the polygon has ", corners, " corners, must have at least 3"));
    Polygon polygon(corners, 2);
    for (int i = 0; i < corners; ++i) {
        const double angle = 2.0 * std::numbers::pi * i / corners;
        polygon.row(i) << std::cos(angle), std::sin(angle);
    }
    return polygon;
}

} // namespace shape
