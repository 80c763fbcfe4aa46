// SPDX-License-Identifier: MIT

#pragma once

#include <utility>
#include <vector>

#include "libshape/mesh/points.h"
#include "libshape/mesh/topology.h"

namespace shape::internal {

/// A mesh and coarser ones of some of its vertices; the first is the mesh itself.
struct TemplateLevel
{
    Topology topology;
    Points rest; ///< [length]

    /// How a vertex of the next finer level follows the vertices of this one: these, with weights of
    /// sum 1. One per vertex of the finer level; empty for the first level.
    std::vector<std::vector<std::pair<int, double>>> followers;
};

/// Levels of a quarter of the vertices each, down to the last one with more than `least` of them.
/// @param least  >= 4.
/// Cost: O(#V log #V).
[[nodiscard]] std::vector<TemplateLevel> template_levels(const Topology& topology,
                                                         const Points& rest, int least);

/// What moved vertices of a level do to those of the finer one: each follows the rotations, growth and
/// displacements of the vertices near it (Sumner, Schmid, Pauly 2007).
struct LevelMesh
{
    Points points;          ///< [length]
    Eigen::VectorXd growth; ///< log of the growth factors, #V.
};
[[nodiscard]] LevelMesh carried_to_finer(const TemplateLevel& coarse, const LevelMesh& moved,
                                         const TemplateLevel& fine);

} // namespace shape::internal
