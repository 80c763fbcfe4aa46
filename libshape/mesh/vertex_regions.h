// SPDX-License-Identifier: MIT

#pragma once

#include <vector>

#include "libshape/mesh/topology.h"

namespace shape::internal {

/// Some vertices and `rings` rings of neighbours around them, as connected regions: in ascending order
/// of their lowest vertices, each breadth first from there.
/// @param seeds  Vertices, in any order; repeated ones count once.
/// @param rings  >= 0.
/// Cost: O(size of the regions), and a byte a vertex of the mesh.
[[nodiscard]] std::vector<std::vector<int>> regions_around(const Topology& topology,
                                                           const std::vector<int>& seeds,
                                                           int rings);

} // namespace shape::internal
