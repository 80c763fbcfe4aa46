// SPDX-License-Identifier: MIT

#pragma once

#include <cstddef>
#include <vector>

#include "libshape/mesh/points.h"

namespace shape {

/// Frames of a sequence that the others lie between.
struct Keyframes
{
    std::vector<std::size_t> frames; ///< Ascending; the first and the last frame are among them.
    double error = 0.0; ///< Largest difference of a coordinate of any frame from the linear
                        ///< interpolation of the keyframes around it [length].
};

/// Chooses the fewest keyframes such that linear interpolation between neighbouring ones gives every
/// frame back with error <= tolerance (to rounding). Frames are equally spaced in time.
///
/// Frame j may follow keyframe i if its slope (x_j - x_i) / (j - i) lies, for every coordinate x, in
/// the intersection of the intervals (x_k - x_i ± tolerance) / (k - i), i < k < j. The fewest are
/// then a shortest path (Imai and Iri 1988).
///
/// @param frames  At least one; all of one size, finite.
/// @param tolerance  >= 0 [length].
/// @throws InvalidInput if a rule is broken.
/// Cost: O(N L #V), where no admissible pair of keyframes lies L or more frames apart.
[[nodiscard]] Keyframes choose_keyframes(const std::vector<Points>& frames, double tolerance);

} // namespace shape
