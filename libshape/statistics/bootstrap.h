// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <vector>

#include "libshape/linalg/dense.h"
#include "libshape/statistics/grouping.h"

namespace shape {

struct BootstrapOptions
{
    /// The data are drawn anew this many times; >= 1.
    int replicates = 1000;
    /// An interval holds the true value with this probability; in (0, 1).
    double confidence = 0.95;
    /// All draws depend on this.
    std::uint64_t seed = 1;
};

/// @throws InvalidInput naming the first field that breaks its rule.
void check(const BootstrapOptions& options);

/// Draws with replacement, as many blocks in each stratum as it has; a drawn block brings all of
/// its observations. A block lies in the stratum of its first observation.
struct Resampling
{
    Grouping blocks; ///< groups_of_one(): observations are drawn one by one.
    Grouping strata; ///< one_group(): all blocks are drawn alike.
};

/// Of fewer blocks replicates say nothing: of one all are the same, of two half of them are one block twice, so that
/// the true value lies beyond what they span about every other time.
constexpr int least_resampled = 3;

/// Of fewer replicates not even the smallest and the largest lie so far apart: between these of n lies another draw with
/// probability (n - 1) / (n + 1). 39 for 95 %.
/// @param confidence  In (0, 1).
[[nodiscard]] int least_replicates(double confidence);

/// An interval that holds the true value with the confidence asked for.
struct Interval
{
    double low = 0.0;
    double high = 0.0;
};

/// Values of a statistic on resampled observations (Efron 1979), one replicate a row.
/// @param statistic  Takes how often each of the N observations was drawn; gives as many numbers
///     each time. Called from several threads.
/// @throws InvalidInput if blocks and strata disagree in size or replicates < 1.
[[nodiscard]] RowMatrix bootstrap(
    const Resampling& resampling,
    const std::function<Eigen::VectorXd(const Eigen::VectorXd& times)>& statistic,
    const BootstrapOptions& options = {});

/// The interval between two quantiles of replicates that leave equal shares on either side. NaN does not count as a
/// replicate; both ends are NaN if there are fewer than least_replicates(confidence).
/// @throws InvalidInput if confidence is not in (0, 1).
[[nodiscard]] Interval percentile_interval(const Eigen::VectorXd& replicates, double confidence);

/// Quantile of values by linear interpolation of their order statistics (type 7 of Hyndman & Fan
/// 1996). NaN does not count as a value.
/// @param probability  In [0, 1].
/// @throws InvalidInput if there is no value or probability is out of its range.
[[nodiscard]] double quantile(Eigen::VectorXd values, double probability);

/// percentile_interval() of the K largest variances of principal components (divisor: number drawn
/// - 1), as many as asked for. The k-th largest variance of few observations is biased, the first
/// ones upwards (Efron & Tibshirani 1993, section 7.2); the interval is of that estimate.
/// @param coordinates  N by M observations in any orthonormal basis, such as scores of all modes.
/// @param modes  K in [1, M].
/// @throws InvalidInput if a rule is broken, or there are fewer than least_resampled blocks.
/// Cost: (N + M) M^2 for each replicate.
[[nodiscard]] std::vector<Interval> variance_intervals(const RowMatrix& coordinates, int modes,
                                                       const Resampling& resampling,
                                                       const BootstrapOptions& options = {});

} // namespace shape
