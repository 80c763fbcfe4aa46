// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <vector>

#include "libshape/statistics/bootstrap.h"
#include "libshape/statistics/group_comparison.h"
#include "libshape/statistics/grouping.h"

namespace shape {

/// How far the members of groups spread, and how well the differences between means are known.
struct GroupSpread
{
    std::vector<double> variances; ///< G: sum of squares about the mean / (n - 1); 0 for n = 1.
    std::vector<Interval> variance_intervals; ///< G; percentile.
    RowMatrix distances;                      ///< G by G, between the means.
    /// G by G: with the confidence asked for, the true vector from one mean to the other lies within
    /// this distance of the measured one. If it is larger than `distances`, that may be nothing.
    RowMatrix distance_radii;
};

/// Bootstraps groups of N points: blocks are drawn within each group if each lies in one, and
/// jointly if they have members of several (compare_groups()). Replicates in which a group has no
/// member are left out.
/// @param products  N by N inner products of the points.
/// @throws InvalidInput if sizes disagree or an option is out of its range.
/// Cost: N^2 G multiplications for each replicate.
[[nodiscard]] GroupSpread group_spread(const Eigen::MatrixXd& products, const Grouping& groups,
                                       const Grouping& blocks,
                                       const BootstrapOptions& options = {});

/// Whether groups spread alike, by permutation (Anderson 2006; in one dimension Levene 1960):
/// compare_groups() of the distances of the points from the mean of their group, each times
/// sqrt(n / (n - 1)), n the size of the group, since a mean of few lies nearer to them. Groups of one or two are
/// left out, whose members are equally far from their mean in any case. Distances from one mean hang together a
/// little: of groups of n points in many dimensions F is (n - 1) / (n - 2) times too large.
/// @param products  N by N inner products of the points.
/// @throws InvalidInput as compare_groups(). The test stays empty with fewer than two degrees of
/// freedom, or fewer than two groups that are left.
[[nodiscard]] LinearModelTest test_spread(const Eigen::MatrixXd& products, const Grouping& groups,
                                          const Grouping& blocks,
                                          const PermutationOptions& options = {});

} // namespace shape
