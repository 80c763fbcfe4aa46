// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <optional>

#include "libshape/statistics/grouping.h"

// Observations that lie so close together that they may be measurements of the same thing. Given by their N by N
// inner products, about any point.

namespace shape::internal {

/// Root mean square distance of the observations of one block, over that of observations of two blocks. About 1
/// where the blocks have nothing to do with the observations; infinite if there are no such pairs, or no distance
/// between blocks.
/// @param strata  Pairs of observations of two strata do not count.
/// @throws InvalidInput if a grouping is of another number of observations.
/// Cost: O(N^2).
[[nodiscard]] double closeness(const Eigen::MatrixXd& products, const Grouping& blocks,
                               const Grouping& strata);

/// The sets that the observations fall into by themselves: clusters of single linkage at the widest relative gap of
/// heights, from the minimum spanning tree (Gower and Ross 1969). At least three, with two observations or more on
/// average, and each at least three times as far from the next one as the longest edge that joins the members of a set.
/// Of several such partitions the one where that ratio is largest; nothing if there is none, or fewer than six
/// observations. Trees of average linkage are in hierarchical_clustering.h.
/// Cost: O(N^2).
[[nodiscard]] std::optional<Grouping> single_linkage_sets(const Eigen::MatrixXd& products);

} // namespace shape::internal
