// SPDX-License-Identifier: MIT

#pragma once

#include <span>
#include <vector>

#include "libshape/mesh/points.h"
#include "libshape/mesh/topology.h"

namespace shape::internal {

/// Meshes that a rigid motion takes onto one another, in lists of two and more; every list ascends, as
/// do their first members. Mirror images and meshes of another scale are not congruent.
///
/// Mesh i is congruent to the first one j of a list if, with d = 1e-6 * (diagonal of j),
/// - abs(l_e - l'_e) <= d for every edge e, and
/// - after the best rigid motion no vertex is further than d from its place.
/// Rounding to single precision, as exporters do, moves a vertex by 6e-8 of its coordinates.
/// @param meshes  Each #V by 3 of finite numbers.
/// Cost: O(N #E), and for each pair of meshes of one size the edges up to the first that differs.
[[nodiscard]] std::vector<std::vector<std::size_t>> congruent_meshes(
    const Topology& topology, std::span<const Points> meshes);

} // namespace shape::internal
