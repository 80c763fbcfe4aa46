// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <vector>

#include "libshape/embedding/energy/length_dihedral_energy.h"

namespace shape::internal {

struct HotSpotOptions
{
    double seeds = 0.7;     ///< At most, times the root of #V: creases are curves.
    double contrast = 12.0; ///< A seed is strained more than this times the mean vertex.
    int rings = 3;          ///< Rings of vertices around the seeds; >= 0.
};

/// Where a mesh is strained far more than elsewhere: the vertices whose edges carry the largest sums
/// of phi (length_dihedral_energy.h) and the rings around them, as connected regions
/// (vertex_regions.h). None where strain is spread evenly.
/// @param points  #V by 3, row by row in one vector [length].
/// Cost: O(#E).
[[nodiscard]] std::vector<std::vector<int>> hot_spots(const LengthDihedralEnergy& energy,
                                                      const Eigen::VectorXd& points,
                                                      const HotSpotOptions& options = {});

} // namespace shape::internal
