// SPDX-License-Identifier: MIT

#pragma once

#include "libshape/mesh/points.h"

namespace shape::internal {

/// How far apart two neighbouring numbers of the size of the largest coordinate are [length], in the coarsest format
/// that holds all coordinates; 0 if there is none or all are 0. Formats: double precision, single precision, and
/// decimals of 4 to 9 significant digits (of 4 to 6 that went through single precision), of which those of fixed
/// decimal places are some. Coordinates below 1e-9 of the largest, which are rounding themselves, are not asked.
///
/// What was rounded once and then turned or scaled in double precision does not show it any more.
/// @param points  Finite. Cost: O(#V), for full double precision that of a few vertices.
[[nodiscard]] double coordinate_spacing(const Points& points);

} // namespace shape::internal
