// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <vector>

#include "libshape/embedding/energy/length_dihedral_energy.h"

namespace shape::internal {

struct HotSpotOptions
{
    /// There are at most this many times the root of #V seeds, as creases are curves; >= 0.
    double seeds = 0.7;
    /// A vertex is a seed only if it is strained more than this times the mean vertex; >= 0.
    double contrast = 12.0;
    /// A spot takes in this many rings of vertices around its seeds; >= 0.
    int rings = 3;
};

/// @throws InvalidInput naming the first field that breaks its rule.
void check(const HotSpotOptions& options);

/// Where a mesh is strained far more than elsewhere: the vertices whose edges carry the largest sums
/// of phi (length_dihedral_energy.h) and the rings around them, as connected regions
/// (vertex_regions.h). None where strain is spread evenly.
/// @param points  #V by 3, row by row in one vector [length].
/// @throws InvalidInput if an option breaks its rule.
/// Cost: O(#E).
[[nodiscard]] std::vector<std::vector<int>> hot_spots(const LengthDihedralEnergy& energy,
                                                      const Eigen::VectorXd& points,
                                                      const HotSpotOptions& options = {});

} // namespace shape::internal
