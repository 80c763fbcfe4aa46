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
    std::vector<int> counts; ///< G: observations, or what counts as one: see group_spread().
    /// G: sum of squares about the mean / (n - 1). Of residuals, their degrees of freedom for n - 1. NaN where these
    /// are 0, as for n = 1.
    std::vector<double> variances;
    /// G: percentile; NaN for n < least_resampled, fewer replicates than least_replicates(), or if the variance is NaN.
    std::vector<Interval> variance_intervals;
    RowMatrix distances; ///< G by G, between the means; NaN if not determined.
    /// G by G: with the confidence asked for, the true vector from one mean to the other lies within
    /// this distance of the measured one. If it is larger than `distances`, that may be nothing. NaN likewise, and
    /// where fewer than least_resampled observations tell the groups apart: nested, those of the smaller one; crossed,
    /// the blocks that have both, or fewest blocks have two neighbours of any chain of groups between them.
    RowMatrix distance_radii;
};

/// Bootstraps groups of N points, as compare_groups() takes them. Nested, the mean of a block counts as one
/// observation, and blocks are drawn within each group; crossed, the mean of the members of a block that are in one
/// group does, blocks that lie in one group are left out, and blocks are drawn jointly. With covariates means are
/// adjusted, in each replicate anew, and variances are those of the residuals: of what is left of the observations
/// when their covariates are moved to those of their group along the slopes, which for the intervals stay as they
/// are; NaN where one block determines nearly all of a slope within blocks. Replicates in which a group has no member, or a slope is not determined, are left out.
/// @param products  N by N inner products of the points.
/// @param covariates  N by any number, also 0.
/// @throws InvalidInput if sizes disagree, an option is out of its range, or no replicate is left.
/// Cost: N^2 G multiplications for each replicate; twice as many if means are not those of observations.
[[nodiscard]] GroupSpread group_spread(const Eigen::MatrixXd& products, const Grouping& groups,
                                       const Grouping& blocks, const Eigen::MatrixXd& covariates,
                                       const BootstrapOptions& options = {});

/// Whether groups spread alike, by permutation (Anderson 2006; in one dimension Levene 1960):
/// compare_groups() of the distances of the observations of group_spread() from the mean of their group, each times
/// sqrt(n / (n - 1)), n the size of the group, since a mean of few lies nearer to them; of residuals, divided by
/// sqrt(1 - leverage). Groups of one or two are
/// left out, whose members are equally far from their mean in any case, and so are residuals of leverage 1, which are 0. Distances from one mean hang together a
/// little: of groups of n points in many dimensions F is (n - 1) / (n - 2) times too large.
/// @param products  N by N inner products of the points.
/// @param covariates  N by any number, also 0.
/// @throws InvalidInput as compare_groups(). The test stays empty with fewer than two degrees of
/// freedom, or fewer than two groups that are left.
[[nodiscard]] LinearModelTest test_spread(const Eigen::MatrixXd& products, const Grouping& groups,
                                          const Grouping& blocks, const Eigen::MatrixXd& covariates,
                                          const PermutationOptions& options = {});

} // namespace shape
