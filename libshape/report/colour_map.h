// SPDX-License-Identifier: MIT

#pragma once

#include <cstddef>

#include "libshape/report/image.h"

namespace shape {

enum class ColourMap
{
    Sequential, ///< 0 dark blue to 1 light yellow; for magnitudes.
    Diverging,  ///< 0 blue, 0.5 light grey, 1 red, equally light on both sides; for signed values.
};

/// The colour of a value in [0, 1]; values outside count as the nearer end, NaN as grey.
/// Lightness runs linearly in Oklab (Ottosson 2020): equal steps of the value look equally large.
[[nodiscard]] Colour map_colour(ColourMap map, double value);

/// The colour of the i-th category: the eight of Okabe and Ito (2008), which people with any
/// colour vision tell apart, without black and yellow (too faint on white); repeats after six.
[[nodiscard]] Colour category_colour(std::size_t category);

} // namespace shape
