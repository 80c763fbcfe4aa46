// SPDX-License-Identifier: MIT

#pragma once

#include <array>
#include <optional>
#include <vector>

#include "libshape/mesh/points.h"

namespace shape::internal {

/// Three corners of a polygon, by their place in it.
using CutTriangle = std::array<int, 3>;

/// Whether a triangle of the cut lies against the polygon: its normal n and that of the polygon, N = the sum of the
/// normals of its fan (Newell's), both weighted by area, have n . N <= 1e-12 N . N.
/// @param corners  A row a corner, at least 3, finite.
[[nodiscard]] bool folds_over(const Points& corners, const std::vector<CutTriangle>& cut);

/// The same of the fan from the first corner: (0, 1, 2), (0, 2, 3), ...
[[nodiscard]] bool fan_folds_over(const Points& corners);

/// Cuts a polygon into triangles: by the fan, unless it folds over, as that of a polygon with a reflex corner may; then by
/// ears of the polygon seen along N, at each step that with the largest area for its longest side squared. Corners
/// may lie on one another or on sides, as those of a slit that leads to a hole do.
/// @param corners  As above.
/// @return #corners - 2 triangles, each running as the polygon does; none if every cut folds over, as of a polygon that
///     crosses itself. Of a polygon without area, the fan.
/// Cost: O(#corners) for fans that do, else O(#corners^2), of odd shapes more.
[[nodiscard]] std::optional<std::vector<CutTriangle>> cut_polygon(const Points& corners);

} // namespace shape::internal
