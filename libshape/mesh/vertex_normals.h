// SPDX-License-Identifier: MIT

#pragma once

#include "libshape/mesh/points.h"

namespace shape::internal {

/// Normals of vertices, as the faces' areas weigh them, unit length or 0.
[[nodiscard]] Points vertex_normals(const Points& points, const Faces& faces);

/// sum (x - c) . n dA / sum |x - c| dA, c the centroid: about 1 of a surface seen from outside, -1 of
/// one that is inside out, 0 where neither can be told.
[[nodiscard]] double outwardness(const Points& points, const Faces& faces);

} // namespace shape::internal
