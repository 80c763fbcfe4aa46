// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <vector>

#include "libshape/embedding/length_dihedral_energy.h"
#include "libshape/mesh/points.h"

namespace shape {

struct FoldRepairOptions
{
    double fold_angle = 1.0;    ///< An edge is folded where |theta - theta*| exceeds this [rad],
    double suspect_angle = 0.5; ///< and suspect where it exceeds this [rad].
    int rings = 3;              ///< Rings of vertices around suspect wedges that move along; >= 0.
    int shaken_starts = 4;      ///< >= 0.
    int trial_iterations = 6;   ///< Gauss-Newton steps from every start,
    int final_iterations = 5;   ///< and of the three best ones after that.
    int largest_region = 2000;  ///< Larger regions are left alone [vertices].
};

struct FoldRepair
{
    Eigen::VectorXd points; ///< All vertices, row by row [length].
    int regions = 0;        ///< Regions that were looked at.
    int replaced = 0;       ///< Of these, where another start won.
};

/// Turns triangles back that lie folded over, or bulge to the wrong side: there the energy has
/// strict local minima, which no descent leaves. Every connected region of suspect edges with a fold
/// among them is solved anew, its surroundings held: as it is, from each reference mesh bent into
/// the place as rigidly as possible (Sorkine and Alexa 2007), which is unfolded where the reference
/// is, and from seeded shakings of it. The lowest energy stays; so the energy never rises.
/// @param references  Meshes of the same topology.
/// @param points  Row by row [length].
[[nodiscard]] FoldRepair repair_folds(const LengthDihedralEnergy& energy,
                                      const std::vector<Points>& references, Eigen::VectorXd points,
                                      const FoldRepairOptions& options = {});

} // namespace shape
