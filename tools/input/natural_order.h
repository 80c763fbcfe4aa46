// SPDX-License-Identifier: MIT

#pragma once

#include <string>
#include <vector>

namespace shape::tools {

/// Sorts names as people order them: numbers by value (s2, s10; x_-1.5, x_-0.5, x_0, x_2), everything else by
/// character; their endings (.ply) come last (s.ply, s-1.ply); equal ones by character alone.
///
/// A number is a run of digits with a decimal part if a point and a digit follow, unless two points do at that place in some name
/// (versions and dates: v1.2, v1.10, v1.10.1), and a sign before it unless that
/// follows a digit (2020-01-05). Behind a letter or another hyphen a hyphen may separate as well: it is a sign if, of
/// all the names, one has a number without it at the same place (t-0.5 beside t0; s-9 beside s-10 is none).
void sort_naturally(std::vector<std::string>& names);

} // namespace shape::tools
