// SPDX-License-Identifier: MIT

#pragma once

#include <string>
#include <vector>

#include "libshape/mesh/points.h"

namespace shape {

/// A surface as a scanner gives it: triangles, of which no topology is asked. Holes, several
/// components, edges with three faces and vertices that occur twice are all right.
struct Scan
{
    Points points; ///< Of vertices that a face names [length]; finite, each position once.
    Faces faces;   ///< Of area > 0; the vertices of each are distinct. At least one.
    std::vector<std::string> ignored; ///< What was left out, a sentence each.
};

/// Leaves out what says nothing about the surface: vertices with a coordinate that is not finite and
/// their faces, faces without area, faces that occur twice, vertices without a face; vertices at one
/// place become one. A face is without area as find_degenerate_geometry() has it (mesh/defects.h):
/// area <= 1e-14 times the square of its longest edge.
/// @throws InvalidInput if a face names a vertex that there is not, or no face is left.
/// Cost: O(#F log #F).
[[nodiscard]] Scan clean_scan(const Points& points, const Faces& faces);

} // namespace shape
