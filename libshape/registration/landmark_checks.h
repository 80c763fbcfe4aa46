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

/// Refuses landmarks whose coordinates are all exactly 0, as several programs write one that is missing: two and more of them,
/// or one that is more than 5 % of the diagonal from every vertex of the surface; an origin that was put at a landmark is on
/// the surface.
/// @throws InvalidInput naming all of them.
void check_not_zero(const std::vector<std::string>& names, const Points& landmarks,
                    const Points& surface, const std::string& whose);

/// Whether landmarks lie on a line or in one point, as near as they are picked by hand: a turn is left open then. Fewer than
/// three do.
[[nodiscard]] bool is_on_line(const Points& landmarks);

/// Refuses three landmarks and more that do; of those that all lie within 0.1 % of the surface's diagonal it says so.
/// @throws InvalidInput
void check_not_on_line(const Points& landmarks, const Points& surface, const std::string& whose);

/// Whether landmarks look as if slips had put them beside the wrong ones: some that are exchanged, or all as in a mirror.
/// A similarity takes those of the template to those of the scan. It misses them by 5 % of their spread (spread(), root
/// of the sum of squares) or more, and with two rows exchanged, or the template's points reflected, by at most a third of
/// that. Of five landmarks and more up to six exchanges after each other count as well, if they leave at most half of what
/// fewer do: several pairs, or three and more that stand in each other's places. Of 4 to 12 random landmarks that differ by
/// random errors of 20 % (standard deviation, of theirs) 1 set of 1,500 does so, of 40 % two, with no slip at all; several
/// exchanges of 5 to 8 in none of 860 sets of either. Two pairs or three in a circle of 5 to 12, errors 5 %, were
/// found in all of 60 sets each, three pairs in 53 and 59.
/// @return A sentence with the slip that explains most and all that it moves, or all that are one point on one side
///     alone. Of fewer than four landmarks nothing else, and no mirror image of landmarks in a plane, which have none.
/// Cost: 3 by 3 singular values for each pair of landmarks, 2 to 30 times in each of six rounds.
[[nodiscard]] std::optional<std::string> mistaken_landmarks(const std::vector<std::string>& names,
                                                            const Points& on_template,
                                                            const Points& on_scan);

} // namespace shape::internal
