// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <vector>

#include "libshape/mesh/topology.h"

namespace shape::internal {

/// A mesh at one place of a path, followed there from one of its ends.
struct BranchPlace
{
    Eigen::VectorXd angles;   ///< #E dihedral angles [rad].
    Eigen::VectorXd energies; ///< #E, what edges add to E (length_dihedral_energy.h).
};

/// A part of a mesh that two branches fold differently, and where one goes over into the other.
struct FoldCrossing
{
    std::vector<int> edges; ///< Interior ones that differ somewhere, ascending.
    double centre = 0.0;    ///< Place, counted from 0: half-way between two.
};

/// How meshes followed from the beginning of a path go over into those followed from its end.
struct BranchCrossings
{
    std::vector<FoldCrossing> folds;
    std::vector<int> fold_of_edge; ///< #E, -1 outside all.
    double centre = 0.0;           ///< Of all else: the mean of the folds', or the middle.
    int width = 0;                 ///< Every crossing takes this many places.

    /// How much an edge belongs to the second branch at a place: 0 before its crossing, 1 behind it.
    [[nodiscard]] double share(int edge, std::size_t place) const;
    /// The same of what belongs to no fold, turns of patches above all.
    [[nodiscard]] double share(std::size_t place) const;
    /// Whether any share at a place lies between 0 and 1.
    [[nodiscard]] bool is_between(std::size_t place) const;
};

/// Folds are the connected parts, with a ring of vertices, of edges whose angles differ by more than
/// 0.3 rad at a place of the middle third. Each crosses where that costs least: its centre is between
/// the places k - 1 and k for which
///
///     sum of its first energies at the places before k  +  sum of its second energies from k on
///
/// is least, with room for the crossing at either end.
/// @param first, second  Of the same places, at least 3.
/// @param width  In [1, places - 2].
[[nodiscard]] BranchCrossings branch_crossings(const Topology& topology,
                                               const std::vector<BranchPlace>& first,
                                               const std::vector<BranchPlace>& second, int width);

} // namespace shape::internal
