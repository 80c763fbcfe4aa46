// SPDX-License-Identifier: MIT

#pragma once

#include <cstddef>
#include <vector>

#include "libshape/mesh/points.h"

namespace shape::internal {

/// Meshes that are longer or shorter along one axis than the others, as a wrong voxel spacing or slice thickness makes
/// them.
struct StretchedMeshes
{
    std::vector<std::size_t>
        meshes;          ///< Ascending; fewer than half of all; empty if there are none.
    double factor = 1.0; ///< Geometric mean of theirs, > 0; < 1: shorter.
    int axis =
        -1; ///< 0, 1 or 2 where that axis is a coordinate axis of all of them (within 10 degrees), else -1.
};

/// Every mesh is fitted by an affine image of one of the others, whose singular values s_1 >= s_2 >= s_3 say how it is
/// stretched: g = log(s_1 / s_3), along the axis whose value stands apart more. Reference is the mesh, of five, with the least
/// median g. The meshes beyond some place in the order of g are stretched if all of them
/// - have g > log 1.5, and 1.5 times the g before them, or 1.3 times it along one coordinate axis,
/// - the same way, each by at least 0.8 g along that one axis;
/// and if the median g of the others is below 0.25: poses are not told from stretches.
/// @param meshes  In correspondence; nothing is said of fewer than five.
/// Cost: O(N #V).
[[nodiscard]] StretchedMeshes stretched_meshes(const std::vector<Points>& meshes);

} // namespace shape::internal
