// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>

#include "libshape/mesh/topology.h"

namespace shape::internal {

/// A vertex in the middle of a closed surface whose faces are well shaped: a good point at infinity.
///
/// Among the twentieth (at least 20) of the vertices with the smallest distance to their farthest
/// point, the one with the largest smallest angle in its star; edges that are far from Delaunay
/// count like small angles.
/// @param lengths  #E [length], > 0.
/// Cost: 7 runs of Dijkstra's algorithm.
[[nodiscard]] int central_vertex(const Topology& topology, const Eigen::VectorXd& lengths);

} // namespace shape::internal
