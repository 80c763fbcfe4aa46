// SPDX-License-Identifier: MIT

#pragma once

#include <vector>

#include "libshape/linalg/dense.h"

namespace shape::internal {

/// The natural logarithm of the number of ways in which the rows of a design may change their places without any effect on a test of it: permutations s of its
/// cells, each to one of its kind, for which orthogonal U and V exist with tested[s(c)] = tested[c] U and nuisance[s(c)] =
/// nuisance[c] V for all cells c. Exchanging two groups of a size is one, reversing a covariate that is its own mirror
/// image another.
/// @param tested, nuisance  Rows of the cells in orthonormal columns; a cell is a set of equal rows, and no two of one kind
///     have the same.
/// @param kinds  Of cells that may take each other's place: of one block, and of as many rows.
/// @return At least 0. Where looking for all takes more than some 1e9 operations, that of a divisor of the number.
/// Cost: little where few cells are as far from the origin as each other.
[[nodiscard]] double design_symmetries(const RowMatrix& tested, const RowMatrix& nuisance,
                                       const std::vector<int>& kinds);

} // namespace shape::internal
