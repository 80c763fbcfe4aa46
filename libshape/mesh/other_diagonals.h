// SPDX-License-Identifier: MIT

#pragma once

#include <optional>
#include <vector>

#include "libshape/mesh/points.h"

namespace shape::internal {

/// Polygons that two triangulations of the same vertices cut along other diagonals.
struct OtherDiagonals
{
    Eigen::Index polygons = 0; ///< At least 1.
    Eigen::Index quads = 0;    ///< Those of them that have four corners.
    std::vector<int> first;    ///< Corners of the one with the lowest vertex, from that.
};

/// Whether two triangulations differ in the diagonals of polygons alone. Triangles of one that the other has not, joined
/// across sides that the other has not, are patches; each must be a polygon, k triangles within one loop of k + 2
/// different vertices, and the patches of both have the same loops. Vertices in another order leave others: what lies
/// about an inner vertex has it inside, and at the rim the loops differ.
/// @param other  Any triples of numbers, as `reference`.
/// @return Nothing if they do not, or have the same triangles.
/// Cost: O(#F log #F).
[[nodiscard]] std::optional<OtherDiagonals> other_diagonals(const Faces& reference,
                                                            const Faces& other);

} // namespace shape::internal
