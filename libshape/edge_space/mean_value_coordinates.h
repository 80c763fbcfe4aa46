// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>

namespace shape {

/// Corners of a polygon in the plane, n by 2, in order, either way round; the last is joined to the
/// first.
using Polygon = Eigen::MatrixX2d;

/// Mean value coordinates of a point with respect to a simple polygon: n numbers that sum to 1, whose
/// combination of the corners is the point (Floater 2003; for any simple polygon Hormann and Floater
/// 2006). Smooth in the interior; on an edge those of its two ends alone, linear; at a corner 1
/// there. Positive inside a convex polygon; elsewhere some may be negative.
///
/// A point within 1e-12 times the extent of the polygon of a corner or an edge lies on it.
/// @throws InvalidInput if the polygon has fewer than three corners, a value that is not finite, a
///     corner twice, or edges that touch without being neighbours, or neighbours that overlap; or
///     if the point lies outside or is not finite.
/// Cost: O(n^2) for the check of the polygon.
[[nodiscard]] Eigen::VectorXd mean_value_coordinates(const Polygon& polygon,
                                                     const Eigen::Vector2d& point);

/// @throws InvalidInput as above if the polygon is not simple.
void check_simple_polygon(const Polygon& polygon);

/// n corners on the unit circle, counter-clockwise from (1, 0).
/// @throws InvalidInput if there are fewer than three.
[[nodiscard]] Polygon regular_polygon(int corners);

} // namespace shape
