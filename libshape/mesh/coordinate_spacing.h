// SPDX-License-Identifier: MIT

#pragma once

#include <optional>
#include <string>

#include "libshape/mesh/points.h"
#include "libshape/mesh/topology.h"

namespace shape::internal {

/// How far apart two neighbouring numbers of the size of the largest coordinate are [length], in the coarsest format
/// that holds all coordinates; 0 if there is none or all are 0. Formats: double precision, single precision, and
/// decimals of 4 to 9 significant digits (of 4 to 6 that went through single precision), of which those of fixed
/// decimal places are some. Coordinates below 1e-9 of the largest, which are rounding themselves, are not asked.
///
/// What was rounded once and then turned or scaled in double precision does not show it any more.
/// @param points  Finite. Cost: O(#V), for full double precision that of a few vertices.
[[nodiscard]] double coordinate_spacing(const Points& points);

/// Coordinates that are coarse beside the edges of their mesh.
struct CoarseCoordinates
{
    double step = 0.0;  ///< Along one axis all are multiples of it, from the first one on [length].
    double share = 0.0; ///< Of the median edge [1].
    double largest = 0.0;   ///< Coordinate of that axis [length].
    bool is_single = false; ///< All of them are numbers in single precision.
    /// Numbers of that size have no finer steps: the mesh is far from the origin. Else digits were cut off.
    bool is_far = false;
    /// Numbers half as large have finer ones: those of half precision, in whatever unit.
    bool is_far_half = false;
};

/// The axis with the coarsest steps, if these are more than a hundredth of the median edge: rounding then is part of
/// every length. Steps are found in any unit, but not in what was turned after the rounding (coordinate_lattice.h).
///
/// Nothing is said of fewer than 20 vertices or 4 levels, as made by hand in round numbers, and of lattices that are meant
/// (are_meant()); it is always where numbers have no finer steps.
/// @param points  Finite. @param exempt_rasters  Without it, nothing is said of these axes.
/// Cost: O(#F), of double precision with all digits little more than the edges' lengths.
[[nodiscard]] std::optional<CoarseCoordinates> coarse_coordinates(const Faces& faces,
                                                                  const Points& points,
                                                                  bool exempt_rasters = true);

/// "multiples of 0.0625, 20 % of the median edge: single precision has no finer numbers 8.8e+05 from the origin. Export
/// relative to a local origin or in double precision".
[[nodiscard]] std::string describe(const CoarseCoordinates& coarse);

} // namespace shape::internal
