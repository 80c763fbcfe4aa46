// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <vector>

#include "libshape/mesh/topology.h"

namespace shape::internal {

struct FoldRegionOptions
{
    /// An edge is folded where |theta - theta*| exceeds this [rad]; >= suspect_angle.
    double fold_angle = 1.0;
    /// An edge is suspect, and belongs to a region if a folded one is near, where |theta - theta*|
    /// exceeds this [rad]; >= 0.
    double suspect_angle = 0.5;
    /// A region takes in this many rings of vertices around its suspect hinges; >= 0.
    int rings = 3;
};

/// @throws InvalidInput naming the first field that breaks its rule.
void check(const FoldRegionOptions& options);

/// Where a mesh is folded over: vertices of suspect hinges and the rings around them, as connected
/// regions that have a fold among them. Regions in ascending order of their first vertices, vertices
/// breadth first.
/// @param points  #V by 3, row by row in one vector [length].
/// @param dihedral_angles  As wanted, #E [rad]; those of the boundary are not looked at.
/// @throws InvalidInput if an option breaks its rule.
/// Cost: O(#E).
[[nodiscard]] std::vector<std::vector<int>> folded_regions(const Topology& topology,
                                                           const Eigen::VectorXd& points,
                                                           const Eigen::VectorXd& dihedral_angles,
                                                           const FoldRegionOptions& options = {});

} // namespace shape::internal
