// SPDX-License-Identifier: MIT

#pragma once

#include <optional>
#include <string>

#include "libshape/registration/scan_surface.h"

namespace shape::internal {

/// Whether landmarks look as if they were in another unit than a surface, or as if one were in RAS and the other in LPS,
/// which programs of medicine confuse: some are off it, but times a ratio of units (unit_ratio.h), or with x and y times
/// -1, all lie on it, spread over at least a tenth of its diagonal (twice their median distance from their median).
/// @param within  So far from the surface a landmark still lies on it [length].
/// @param what  Whose landmarks they are, such as "the scan".
/// @return A sentence with the cause and the factors, of several the one that brings the landmarks nearest.
///     Nothing if there is none; nor of fewer than three landmarks, which may lie on the surface by chance.
/// Cost: up to 22 times the nearest point of each landmark, O(log #F) each.
[[nodiscard]] std::optional<std::string> other_unit_of(const Points& landmarks,
                                                       const Surface& surface, double within,
                                                       const std::string& what);

} // namespace shape::internal
