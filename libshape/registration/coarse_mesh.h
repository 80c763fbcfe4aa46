// SPDX-License-Identifier: MIT

#pragma once

#include <vector>

#include "libshape/mesh/points.h"
#include "libshape/mesh/topology.h"

namespace shape::internal {

/// A mesh of some of the vertices of another one.
struct CoarseMesh
{
    Topology topology;
    std::vector<int> vertices; ///< Of the fine mesh; ascending.
    Points points;             ///< Theirs [length].
};

/// Collapses edges, the shortest first, until `vertex_count` vertices are left: edges become about
/// equally long. Faces don't turn over, boundary vertices stay on the boundary. More vertices may be
/// left where no edge may collapse. (OpenMesh's decimater.)
/// @param vertex_count  >= 4.
/// Cost: O(#V log #V). Deterministic.
[[nodiscard]] CoarseMesh coarsened(const Topology& topology, const Points& points,
                                   int vertex_count);

} // namespace shape::internal
