// SPDX-License-Identifier: MIT

#include "libshape/statistics/bootstrap.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>

#include "libshape/base/counted.h"
#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/require.h"
#include "libshape/base/threads.h"
#include "libshape/base/to_size.h"
#include "libshape/statistics/bootstrap_draws.h"

namespace shape {
using namespace internal;
namespace {

using Eigen::Index;
using Eigen::VectorXd;

/// The blocks of each stratum.
std::vector<std::vector<int>> blocks_of_strata(const std::vector<std::vector<int>>& blocks,
                                               const Grouping& strata)
{
    std::vector<std::vector<int>> lists(strata.names.size());
    for (std::size_t b = 0; b < blocks.size(); ++b) {
        const int stratum = strata.group_of[to_size(blocks[b].front())];
        lists[to_size(stratum)].push_back(static_cast<int>(b));
    }
    return lists;
}

/// The largest eigenvalues of the covariance of observations drawn so often.
VectorXd largest_variances(const RowMatrix& coordinates, const VectorXd& times, int modes)
{
    const double drawn = times.sum();
    const Eigen::RowVectorXd mean = times.transpose() * coordinates / drawn;
    const RowMatrix weighted = times.cwiseSqrt().asDiagonal() * (coordinates.rowwise() - mean);
    Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(weighted.cols(), weighted.cols());
    covariance.selfadjointView<Eigen::Lower>().rankUpdate(weighted.transpose(),
                                                          1.0 / std::max(drawn - 1.0, 1.0));
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(covariance, Eigen::EigenvaluesOnly);
    return solver.eigenvalues().tail(modes).reverse().cwiseMax(0.0);
}

} // namespace

void check(const BootstrapOptions& options)
{
    require_at_least(1, options.replicates, "BootstrapOptions.replicates");
    require(options.confidence > 0.0 && options.confidence < 1.0, "BootstrapOptions.confidence",
            options.confidence, "in (0, 1)");
}

namespace internal {

BootstrapDraws::BootstrapDraws(const Resampling& resampling, const BootstrapOptions& options)
    : count_(resampling.blocks.size())
{
    check(options);
    if (resampling.blocks.size() != resampling.strata.size())
        throw InvalidInput(join("bootstrap: blocks are of ", resampling.blocks.size(),
                                " observations, strata of ", resampling.strata.size(),
                                "; sizes must agree"));
    blocks_ = members(resampling.blocks);
    strata_ = blocks_of_strata(blocks_, resampling.strata);
    Random seeds(options.seed);
    random_.reserve(to_size(options.replicates));
    for (int r = 0; r < options.replicates; ++r)
        random_.emplace_back(seeds.bits());
}

VectorXd BootstrapDraws::times(int replicate) const
{
    Random random = random_.at(to_size(replicate));
    VectorXd times = VectorXd::Zero(count_);
    for (const std::vector<int>& stratum : strata_)
        for (std::size_t draw = 0; draw < stratum.size(); ++draw) {
            const int block = stratum[random.index(stratum.size())];
            for (const int i : blocks_[to_size(block)])
                times[i] += 1.0;
        }
    return times;
}

} // namespace internal

RowMatrix bootstrap(const Resampling& resampling,
                    const std::function<VectorXd(const VectorXd& times)>& statistic,
                    const BootstrapOptions& options)
{
    const BootstrapDraws draws(resampling, options);
    std::vector<VectorXd> rows(to_size(options.replicates));
    parallel_for(rows.size(), 1, [&](std::size_t r, std::size_t) {
        rows[r] = statistic(draws.times(static_cast<int>(r)));
    });
    RowMatrix result(options.replicates, rows.front().size());
    for (Index r = 0; r < result.rows(); ++r)
        result.row(r) = rows[to_size(r)].transpose();
    return result;
}

double quantile(VectorXd values, double probability)
{
    values.conservativeResize(std::remove_if(values.begin(), values.end(),
                                             [](double value) { return std::isnan(value); }) -
                              values.begin());
    if (values.size() == 0 || !(probability >= 0.0 && probability <= 1.0))
        throw InvalidInput(join("quantile: ", values.size(), " numbers, probability ", probability,
                                "; there must be a number and the probability be in [0, 1]"));
    std::sort(values.begin(), values.end());
    const double place = probability * static_cast<double>(values.size() - 1);
    const auto below = static_cast<Index>(std::floor(place));
    const Index above = std::min(below + 1, values.size() - 1);
    return std::lerp(values[below], values[above], place - std::floor(place));
}

int least_replicates(double confidence)
{
    constexpr double rounding = 1e-9; // 2 / (1 - 0.95) is a little more than 40
    return static_cast<int>(std::ceil(2.0 / (1.0 - confidence) - 1.0 - rounding));
}

Interval percentile_interval(const VectorXd& replicates, double confidence)
{
    if (!(confidence > 0.0 && confidence < 1.0))
        throw InvalidInput(join("interval: confidence is ", confidence, ", must be in (0, 1)"));
    const auto count = (!replicates.array().isNaN()).count();
    if (count < least_replicates(confidence))
        return {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::quiet_NaN()};
    const double outside = 0.5 * (1.0 - confidence);
    return {quantile(replicates, outside), quantile(replicates, 1.0 - outside)};
}

std::vector<Interval> variance_intervals(const RowMatrix& coordinates, int modes,
                                         const Resampling& resampling,
                                         const BootstrapOptions& options)
{
    check(options);
    if (modes < 1 || modes > coordinates.cols() || coordinates.rows() != resampling.blocks.size() ||
        coordinates.rows() < 2)
        throw InvalidInput(join("variance intervals: ", modes, " modes of ", coordinates.rows(),
                                " by ", coordinates.cols(), " coordinates, resampled from ",
                                resampling.blocks.size(),
                                " observations; modes must be in [1, columns], observations agree "
                                "and be at least 2"));
    if (resampling.blocks.group_count() < least_resampled)
        throw InvalidInput(join("variance intervals: what is drawn anew are ",
                                counted(resampling.blocks.group_count(), "observation"),
                                " or blocks of them; at least ", least_resampled, " are needed"));
    if (!coordinates.allFinite())
        throw InvalidInput("variance intervals: a coordinate is not finite");
    const RowMatrix replicates = bootstrap(
        resampling,
        [&](const VectorXd& times) { return largest_variances(coordinates, times, modes); },
        options);
    std::vector<Interval> intervals;
    intervals.reserve(to_size(modes));
    for (int k = 0; k < modes; ++k)
        intervals.push_back(percentile_interval(replicates.col(k), options.confidence));
    return intervals;
}

} // namespace shape
