// SPDX-License-Identifier: MIT

#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "libshape/mesh/points.h"

namespace shape::internal {

/// Faces of any number of corners, as a fan from the first corner each.
struct Fans
{
    std::span<const int> corners; ///< Of all triangles, three each.
    std::span<const std::int64_t>
        polygons; ///< The first triangle of each face of more than 3 corners, ascending.
    std::span<const int> sizes; ///< Corners of these.

    [[nodiscard]] std::vector<int> vertices_of(std::size_t polygon) const;
};

/// Triangles of polygons that are cut as a triangulation of the same vertices has them.
struct KnownCut
{
    std::vector<int> corners; ///< Three a triangle, in the order of the fans.
    std::vector<std::size_t>
        missed; ///< Polygons that it has no such triangles of; they are fans still.
    bool has_all =
        false; ///< Nothing is missed, and these are all of its triangles, in whatever order.
};

/// Cuts a polygon of n corners into the n - 2 triangles of a triangulation that have it as their boundary, which is to
/// say along diagonals of the triangulation that lie in it, wherever these triangles stand; or, of one that runs the
/// other way round, into those triangles reversed.
/// @param known  Any triples of numbers.
/// Cost: O(#F) where triangles stand in the order of the polygons, else O(#F log #F).
[[nodiscard]] KnownCut cut_as_known(const Fans& fans, const Faces& known);

} // namespace shape::internal
