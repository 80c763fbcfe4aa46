// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <vector>

#include "libshape/mesh/topology.h"

namespace shape::internal {

/// Unknowns for the positions of a mesh whose edge lengths range over many orders of magnitude, as
/// those of conformal maps do. With one unknown a vertex, the soft terms that hold a fine region to
/// the rest are lost among the stiff terms of its short edges: 1 and 1e16 at lengths of 1 and 1e-8.
/// So one unknown of every fine region moves all of it, and the others are relative to that.
struct GradedUnknowns
{
    std::vector<int> vertices; ///< Row i is the unknown of vertices[i]: all but one vertex with the
                               ///< longest edges, which is held. Ascending.
    std::vector<std::vector<int>> rows; ///< #V, unknowns whose sum moves a vertex.
};

/// Regions are those connected parts where the shortest edges at the vertices are below a power of
/// 1/300 of the longest such; most meshes have none.
/// @param lengths  #E [length], > 0.
[[nodiscard]] GradedUnknowns graded_unknowns(const Topology& topology,
                                             const Eigen::VectorXd& lengths);

} // namespace shape::internal
