// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <vector>

#include "libshape/embedding/eightfold_descent.h"
#include "libshape/embedding/fold_regions.h"
#include "libshape/embedding/length_dihedral_energy.h"
#include "libshape/mesh/points.h"

namespace shape {

struct FoldRepairOptions
{
    FoldRegionOptions regions = {};
    int largest_region = 2000; ///< Larger regions are left alone [vertices].
    int filling_sweeps = 15;   ///< Of rigid_filling.h, for every reference.
    int shaken_starts = 4;     ///< At least: what is left of the last eight is shaken too; >= 0.
    EightfoldDescentOptions descent = {};
};

struct FoldRepair
{
    Eigen::VectorXd points; ///< All vertices, row by row [length].
    int regions = 0;        ///< Regions that were looked at.
    int replaced = 0;       ///< Of these, where another start won.
};

/// Turns triangles back that lie folded over, or bulge to the wrong side: there the energy has
/// strict local minima, which no descent leaves. Every region (fold_regions.h) is solved anew, its
/// surroundings held, from eight starts in lock-step: as it is, from each reference mesh bent into
/// the place as rigidly as possible (rigid_filling.h), which is unfolded where the reference is, and
/// from seeded shakings of it. The lowest energy stays; so the energy never rises.
/// @param references  Meshes of the same topology.
/// @param points  Row by row [length].
/// Same bits for any number of threads.
[[nodiscard]] FoldRepair repair_folds(const LengthDihedralEnergy& energy,
                                      const std::vector<Points>& references, Eigen::VectorXd points,
                                      const FoldRepairOptions& options = {});

} // namespace shape
