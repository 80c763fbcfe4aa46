// SPDX-License-Identifier: MIT

#pragma once

#include <string>
#include <vector>

namespace shape::tools {

/// Sorts names as people order them: numbers by value (s2, s10; x_-1.5, x_-0.5, x_0, x_2), everything else by
/// character; their endings (.ply) come last (s.ply, s-1.ply); equal ones by character alone.
///
/// A number is a run of digits with a decimal part if a point and a digit follow (0.25, 0.5), and a sign before it
/// unless that follows a digit (2020-01-05). Behind a letter or another hyphen a hyphen may separate as well: it is a
/// sign if, of all the names, one has a number without it at the same place (t-0.5 beside t0; s-9 beside s-10 is none).
///
/// It is a version instead, each number of it by itself (v1.2.9, v1.9, v1.10), where two points stand in it, as in
/// dates, and at every place where they do in some name (run_1.2.9, run_1.10), or where the word before it is `v`, `ver`,
/// `version`, `rev` or `revision`. But where some name has a sign there, or a fraction that begins with a zero (1.05), all with one
/// point are decimals: scan_-2.00, scan_-1.5, scan_0.25, scan_0.5.
void sort_naturally(std::vector<std::string>& names);

} // namespace shape::tools
