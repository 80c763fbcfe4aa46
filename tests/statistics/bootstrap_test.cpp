// SPDX-License-Identifier: MIT

#include "libshape/statistics/bootstrap.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "libshape/base/error.h"
#include "libshape/base/random.h"
#include "libshape/base/to_size.h"
#include "libshape/statistics/principal_components.h"
#include "tests/support/matrices.h"
#include "tests/support/thread_scope.h"

namespace shape {
using namespace internal;
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

Resampling plain(Index count)
{
    return {groups_of_one(count), one_group(count)};
}

TEST(Bootstrap, OfAMeanHasItsStandardError)
{
    const VectorXd data = test::random_matrix(400, 1, 1);
    const RowMatrix means = bootstrap(
        plain(400),
        [&](const VectorXd& times) { return VectorXd::Constant(1, times.dot(data) / 400.0); },
        {.replicates = 4000});
    const double error = std::sqrt((means.array() - means.mean()).square().mean());
    const double expected = std::sqrt((data.array() - data.mean()).square().mean() / 400.0);
    EXPECT_NEAR(error, expected, 0.05 * expected); // its own standard error is 1.1 %
    EXPECT_NEAR(means.mean(), data.mean(), 5.0 * expected / std::sqrt(4000.0));
}

TEST(Bootstrap, DrawsBlocksAsAWholeAndAsManyFromEachStratum)
{
    const Resampling resampling{group_by({"1", "1", "2", "3", "3", "4", "5"}),
                                group_by({"a", "a", "a", "b", "b", "b", "b"})};
    const RowMatrix draws =
        bootstrap(resampling, [](const VectorXd& times) { return times; }, {.replicates = 300});
    for (Index r = 0; r < draws.rows(); ++r) {
        EXPECT_EQ(draws(r, 0), draws(r, 1));
        EXPECT_EQ(draws(r, 3), draws(r, 4));
        EXPECT_EQ(draws(r, 0) + draws(r, 2), 2.0);
        EXPECT_EQ(draws(r, 3) + draws(r, 5) + draws(r, 6), 3.0);
    }
    EXPECT_EQ(draws.col(6).maxCoeff(), 3.0);
    EXPECT_NEAR(draws.col(6).mean(), 1.0, 5.0 * std::sqrt(2.0 / 3.0 / 300.0));
}

TEST(Bootstrap, HasTheSameBitsForAnyThreadCount)
{
    const auto draws = [](int threads, std::uint64_t seed) {
        const test::ThreadScope scope(threads);
        return bootstrap(plain(9), [](const VectorXd& times) { return times; },
                         {.replicates = 50, .seed = seed});
    };
    EXPECT_EQ(draws(1, 1), draws(3, 1));
    EXPECT_NE(draws(1, 1), draws(1, 2));
}

TEST(Quantile, InterpolatesOrderStatistics)
{
    const VectorXd values = Eigen::Vector4d(4.0, 1.0, 3.0, 2.0);
    EXPECT_EQ(quantile(values, 0.0), 1.0);
    EXPECT_EQ(quantile(values, 0.25), 1.75);
    EXPECT_EQ(quantile(values, 0.5), 2.5);
    EXPECT_EQ(quantile(values, 1.0), 4.0);
    VectorXd gap(5);
    gap << values, std::numeric_limits<double>::quiet_NaN();
    EXPECT_EQ(quantile(gap, 0.25), 1.75);
    EXPECT_THROW((void)quantile(VectorXd(), 0.5), InvalidInput);
    EXPECT_THROW((void)quantile(gap.tail(1), 0.5), InvalidInput);
    for (const double bad : {-0.1, 1.1, std::numeric_limits<double>::quiet_NaN()})
        EXPECT_THROW((void)quantile(values, bad), InvalidInput);
}

TEST(PercentileInterval, LeavesEqualSharesOnEitherSide)
{
    const VectorXd values = VectorXd::LinSpaced(1001, 0.0, 1000.0);
    const Interval interval = percentile_interval(values, 0.9);
    EXPECT_NEAR(interval.low, 50.0, 1e-10);
    EXPECT_NEAR(interval.high, 950.0, 1e-10);
    for (const double bad : {0.0, 1.0, -0.5})
        EXPECT_THROW((void)percentile_interval(values, bad), InvalidInput);
}

TEST(PercentileInterval, TakesAsManyReplicatesAsItsConfidenceAsksFor)
{
    EXPECT_EQ(least_replicates(0.95), 39);
    EXPECT_EQ(least_replicates(0.9), 19);
    EXPECT_EQ(least_replicates(0.99), 199);
    EXPECT_EQ(least_replicates(0.5), 3);
    const VectorXd values = VectorXd::LinSpaced(39, 1.0, 39.0);
    EXPECT_GT(percentile_interval(values, 0.95).high, percentile_interval(values, 0.95).low);
    VectorXd fewer = values;
    fewer[7] = std::numeric_limits<double>::quiet_NaN();
    for (const VectorXd& few : {fewer, VectorXd(values.head(38)), VectorXd(values.head(1))}) {
        EXPECT_TRUE(std::isnan(percentile_interval(few, 0.95).low));
        EXPECT_TRUE(std::isnan(percentile_interval(few, 0.95).high));
    }
    // Where another draw lies: between the least and the largest of 38 seldom enough, of 39 not.
    Random random(1);
    const auto share_between_ends = [&](int count) {
        constexpr int repetitions = 100'000;
        int held = 0;
        for (int i = 0; i < repetitions; ++i) {
            double low = 1.0, high = 0.0;
            for (int k = 0; k < count; ++k) {
                const double drawn = random.uniform();
                low = std::min(low, drawn);
                high = std::max(high, drawn);
            }
            const double other = random.uniform();
            held += low <= other && other <= high;
        }
        return held / static_cast<double>(repetitions);
    };
    EXPECT_NEAR(share_between_ends(39), 0.95, 0.0035);
    EXPECT_NEAR(share_between_ends(9), 0.8, 0.0065);
}

TEST(VarianceIntervals, HoldTheTrueVariances)
{
    // Independent normal coordinates of standard deviations 3, 2 and 1; an interval of 95 % of a
    // normal sample of 100 is a little too narrow: 90 % is expected at least.
    int held[3] = {0, 0, 0};
    constexpr int repetitions = 100;
    for (unsigned repetition = 0; repetition < repetitions; ++repetition) {
        const RowMatrix data =
            test::random_matrix(100, 3, repetition) * Eigen::Vector3d(3.0, 2.0, 1.0).asDiagonal();
        const std::vector<Interval> intervals =
            variance_intervals(data, 3, plain(100), {.replicates = 200, .seed = repetition});
        const double truth[] = {9.0, 4.0, 1.0};
        for (int k = 0; k < 3; ++k)
            held[k] +=
                intervals[to_size(k)].low <= truth[k] && truth[k] <= intervals[to_size(k)].high;
    }
    for (const int count : held) {
        EXPECT_GE(count, 84);
        EXPECT_LT(count, repetitions);
    }
}

TEST(VarianceIntervals, AreOfPrincipalComponentsInAnyBasis)
{
    const RowMatrix data = test::random_matrix(30, 6, 5) * test::random_matrix(6, 6, 6);
    const PrincipalComponents components = principal_components(data);
    const auto direct = variance_intervals(data, 2, plain(30), {.replicates = 50});
    const auto scores = variance_intervals(components.scores, 2, plain(30), {.replicates = 50});
    for (std::size_t k = 0; k < 2; ++k) {
        EXPECT_NEAR(scores[k].low, direct[k].low, 1e-11 * direct[k].low);
        EXPECT_NEAR(scores[k].high, direct[k].high, 1e-11 * direct[k].high);
        EXPECT_LT(direct[k].low, components.variances[static_cast<Index>(k)]);
        EXPECT_GT(direct[k].high, components.variances[static_cast<Index>(k)]);
    }
}

TEST(Bootstrap, RefusesWhatBreaksARule)
{
    const auto sum = [](const VectorXd& times) { return VectorXd::Constant(1, times.sum()); };
    EXPECT_THROW((void)bootstrap({groups_of_one(4), one_group(5)}, sum), InvalidInput);
    EXPECT_THROW((void)bootstrap(plain(4), sum, {.replicates = 0}), InvalidInput);
    const RowMatrix data = test::random_matrix(5, 3, 7);
    EXPECT_THROW((void)variance_intervals(data, 0, plain(5)), InvalidInput);
    EXPECT_THROW((void)variance_intervals(data, 4, plain(5)), InvalidInput);
    EXPECT_THROW((void)variance_intervals(data, 1, plain(4)), InvalidInput);
    EXPECT_THROW((void)variance_intervals(data.topRows(1), 1, plain(1)), InvalidInput);
    // Of two blocks, however many observations they have.
    EXPECT_THROW((void)variance_intervals(data.topRows(2), 1, plain(2)), InvalidInput);
    const Grouping two = group_by({"1", "1", "1", "2", "2"});
    EXPECT_THROW((void)variance_intervals(data, 1, {two, one_group(5)}), InvalidInput);
    const Grouping three = group_by({"1", "1", "3", "2", "2"});
    EXPECT_NO_THROW((void)variance_intervals(data, 1, {three, one_group(5)}));
    RowMatrix infinite = data;
    infinite(0, 0) = std::numeric_limits<double>::infinity();
    EXPECT_THROW((void)variance_intervals(infinite, 1, plain(5)), InvalidInput);
}

} // namespace
} // namespace shape
