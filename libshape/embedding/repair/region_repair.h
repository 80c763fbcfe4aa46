// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <vector>

#include "libshape/embedding/energy/eight_lane_descent.h"
#include "libshape/embedding/energy/length_dihedral_energy.h"
#include "libshape/mesh/points.h"

namespace shape::internal {

struct RegionRepairOptions
{
    /// Regions of more vertices are left alone; >= 0.
    int largest_region = 2000;
    /// Every reference is bent into the place by this many sweeps (rigid_filling.h); >= 0.
    int filling_sweeps = 8;
    /// At least this many starts are random perturbations; as many more fill the last eight; >= 0.
    int perturbed_starts = 4;
    /// All starts descend by these.
    EightLaneDescentOptions descent = {};
};

/// @throws InvalidInput naming the first field that breaks its rule.
void check(const RegionRepairOptions& options);

struct RegionRepair
{
    Eigen::VectorXd points; ///< All vertices, row by row [length].
    int replaced = 0;       ///< Regions where E fell,
    double decrease = 0.0;  ///< and by how much in all.
};

/// Solves regions anew where the energy has strict local minima, which no descent leaves: triangles
/// that lie folded over, or bulge to the wrong side (fold_regions.h), or are far from any minimum
/// (hot_spots.h). The surroundings of every region are held. It starts in eight SIMD lanes as it is, from
/// each reference mesh bent into the place as rigidly as possible (rigid_filling.h), which is unfolded
/// where the reference is, and from seeded random perturbations. The lowest energy stays; so the energy never
/// rises.
/// @param references  Meshes of the same topology.
/// @param points  Row by row [length].
/// @param regions  Disjoint, each connected; one that is the whole mesh is left alone.
/// @throws InvalidInput if an option breaks its rule.
/// Same bits for any number of threads.
[[nodiscard]] RegionRepair repair_regions(const LengthDihedralEnergy& energy,
                                          const std::vector<Points>& references,
                                          Eigen::VectorXd points,
                                          std::vector<std::vector<int>> regions,
                                          const RegionRepairOptions& options = {});

} // namespace shape::internal
