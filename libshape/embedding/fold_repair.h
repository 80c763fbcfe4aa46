// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <vector>

#include "libshape/embedding/length_dihedral_energy.h"
#include "libshape/mesh/points.h"

namespace shape {

struct FoldRepairOptions
{
    double suspect_angle = 0.4; ///< An edge is suspect where |theta - theta*| exceeds this [rad].
    double fold_angle = 1.0;    ///< Beyond this [rad] it is a fold, and references are tried too.
    int rings = 4;              ///< Rings of vertices around suspect wedges that move along; >= 0.
    int max_iterations = 6;     ///< Gauss-Newton steps from each start.
    int largest_region = 2000;  ///< Larger regions are left alone [vertices].
};

struct FoldRepair
{
    Eigen::VectorXd points; ///< All vertices, row by row [length].
    int regions = 0;        ///< Regions that were looked at.
    int replaced = 0;       ///< Of these, where another candidate won.
};

/// Turns triangles back that lie folded over: there the energy has strict local minima, which no
/// descent leaves. Every connected region of suspect edges is solved anew, its surroundings held: as
/// it is, and where it has a fold from each reference mesh bent into the place as rigidly as
/// possible (Sorkine and Alexa 2007) too, which is unfolded where the reference is. The lowest
/// energy stays; so the energy never rises.
/// @param references  Meshes of the same topology.
/// @param points  Row by row [length].
[[nodiscard]] FoldRepair repair_folds(const LengthDihedralEnergy& energy,
                                      const std::vector<Points>& references, Eigen::VectorXd points,
                                      const FoldRepairOptions& options = {});

} // namespace shape
