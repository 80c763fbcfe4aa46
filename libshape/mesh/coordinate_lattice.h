// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>

#include "libshape/mesh/points.h"
#include "libshape/mesh/topology.h"

namespace shape::internal {

/// Coordinates along an axis that are all multiples of a step, from one of them on.
struct Lattice
{
    double step = 0.0; ///< [length]
    /// Of those alone that are more than half as far from the origin as the farthest: numbers of few digits, as those of half
    /// precision, are coarser there.
    bool is_far_half = false;
    Eigen::VectorXi levels; ///< A vertex: its multiple, from 0 on; -1 where it is none.
    int level_count = 0;    ///< Different ones.
};

/// The lattice of some coordinates with the largest step, if that is above `least`: whatever the unit, each is within 0.02 of
/// a multiple of the step.
/// @return Nothing where it has fewer than 4 levels (20 of a far half), as chance and hands make them.
/// Cost: O(n log n).
[[nodiscard]] std::optional<Lattice> find_lattice(const Eigen::VectorXd& coordinates, double least);

/// Which of the axes that have a lattice are meant to have it: the data are made of slices, pixels, voxels or plates, and
/// nothing was rounded. An axis is, if along it
/// - 99 % of the edges run to the same or the next level that has vertices, as in slices, rasters (graded ones, too) and voxels;
///   or by two steps, where another axis is of that kind, or where 97 % of the vertices are halfway between voxels
///   along one axis, as marching cubes leave them;
/// - half of the vertices share a level of three and more of which both neighbouring multiples have none, and 80 % of the edges
///   run to the second next level at most;
/// - vertices that rounding would move off the surface (abs(n) >= 0.25 along it, no plateau) are on it: their distance from a
///   quadric through two rings has a median below 0.2 of the standard deviation that rounding leaves, step / sqrt(12); or
/// - both other axes are of the first two kinds, and the median is 3 and more of that: uneven heights.
/// Levels that are flat steps of a slanted surface are no slices, if no other axis is of that kind: 2 % of the vertices have all
/// neighbours on their level, of three levels at the least, and most edges between levels do not run along the axis.
/// All three are, if fewer than two are of the first two kinds, their steps are within a factor of 12, 60 % of the edges, 200
/// at the least, run by at most one step along every axis, and none has lost its length: of rounded ones many would have.
/// All three are of a part made of planes: of 99 % of the edges both faces lie in one plane or meet at more than 26 degrees.
/// @param lattices  Of the axes.
/// Cost: O(#V + #F).
[[nodiscard]] std::array<bool, 3> are_meant(const Faces& faces, const Points& points,
                                            const std::array<std::optional<Lattice>, 3>& lattices);

} // namespace shape::internal
