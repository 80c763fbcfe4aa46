// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <utility>
#include <vector>

#include "libshape/registration/growth_energy.h"
#include "libshape/registration/rims.h"
#include "libshape/registration/scan_surface.h"

namespace shape::internal {

/// How strongly a scan pulls in one round of closest points.
struct PullRule
{
    double weight = 1.0; ///< Of a pair at no distance [1 / unit^2].
    double scale = 1.0;  ///< Of Welsch's weights exp(-d^2 / (2 scale^2)) [length].
};

/// The faces that nearest points were found on, to begin with when they are looked for again after a small
/// move; empty before the first time. They change no result.
struct LastPairs
{
    std::vector<int> on_scan; ///< Of the mesh's vertices; -1: none.
    std::vector<int> on_mesh; ///< Of the scan's samples.
};

/// Adds what a scan does to a mesh by pairs of nearest points whose normals agree (n . n' >= 0.3), along
/// n + n' (Rusinkiewicz 2019): from every vertex of the mesh, and from about as many of the scan. Pairs
/// that end at a rim are left out: beyond it the other surface may go on unseen.
/// @param last  Of the last call with this scan and topology.
void add_surface_pulls(const Surface& scan, const Topology& topology, const Points& points,
                       const PullRule& rule, GrowthEnergy& energy, LastPairs& last);

/// Adds what rims of a scan do to rims of a mesh, across the rims: pairs of loops whose mean distance
/// is below a tenth of their lengths, the nearest first, each loop once. The longest loop of a mesh is
/// where a scan ends anywhere: of it only pairs within a few times their median distance count.
/// @param named  Pairs (loop of the mesh, loop of the scan) that correspond whatever their distance.
void add_rim_pulls(const Surface& scan, const Rims& rims, const Points& points,
                   const std::vector<std::pair<int, int>>& named, const PullRule& rule,
                   GrowthEnergy& energy);

} // namespace shape::internal
