// SPDX-License-Identifier: MIT

#pragma once

#include "libshape/mesh/points.h"

namespace shape::internal {

/// Normals of vertices, as the faces' areas weigh them, unit length or 0.
[[nodiscard]] Points vertex_normals(const Points& points, const Faces& faces);

} // namespace shape::internal
