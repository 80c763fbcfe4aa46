// SPDX-License-Identifier: MIT

#pragma once

#include <optional>
#include <string>
#include <vector>

#include "libshape/mesh/points.h"

namespace shape::internal {

/// Refuses landmarks that lie nowhere near a surface though others do: -9999 is a common code for a missing one.
/// @param landmarks  Row i is that of names[i].
/// @param whose  "the scan".
/// @throws InvalidInput naming those that are more than 20 diagonals from the middle of the surface, if not all are.
void check_not_far(const std::vector<std::string>& names, const Points& landmarks,
                   const Points& surface, const std::string& whose);

/// Whether landmarks look as if a slip had put them beside the wrong ones: two that are exchanged, or all as in a mirror.
/// A similarity takes those of the template to those of the scan. It misses them by 5 % of their spread (spread(), root
/// of the sum of squares) or more, and with two rows exchanged, or the template's points reflected, by at most a third of
/// that. Of 4 to 12 random landmarks that differ by random errors of 20 % (standard deviation, of theirs) 1 set of
/// 1,500 does so, of 40 % two, with no slip at all.
/// @return A sentence with the slip that explains most, or the first two that are one point on one side alone. Of fewer than
///     four landmarks nothing else, and no mirror image of
///     landmarks in a plane, which have none.
/// Cost: 3 by 3 singular values for each pair of landmarks.
[[nodiscard]] std::optional<std::string> mistaken_landmarks(const std::vector<std::string>& names,
                                                            const Points& on_template,
                                                            const Points& on_scan);

} // namespace shape::internal
