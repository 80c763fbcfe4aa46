// SPDX-License-Identifier: MIT

#include "libshape/statistics/group_spread.h"

#include <gtest/gtest.h>

#include "libshape/base/error.h"
#include "libshape/statistics/inner_products.h"
#include "tests/support/matrices.h"
#include "tests/support/thread_scope.h"

namespace shape {
namespace {

using Eigen::Index;

/// Two groups of 30 points in five coordinates, the second moved by `move` in each.
RowMatrix two_groups(unsigned seed, double move)
{
    RowMatrix data = test::random_matrix(60, 5, seed);
    data.bottomRows(30).array() += move;
    return data;
}

Grouping halves()
{
    std::vector<std::string> labels;
    for (int i = 0; i < 60; ++i)
        labels.push_back(i < 30 ? "a" : "b");
    return group_by(labels);
}

TEST(GroupSpread, MeasuresVariancesAndDistancesOfMeans)
{
    const RowMatrix data = two_groups(1, 2.0);
    const GroupSpread result =
        group_spread(inner_products(data), halves(), groups_of_one(60), {.replicates = 50});
    const Eigen::RowVectorXd a = data.topRows(30).colwise().mean();
    const Eigen::RowVectorXd b = data.bottomRows(30).colwise().mean();
    EXPECT_NEAR(result.variances[0], (data.topRows(30).rowwise() - a).squaredNorm() / 29.0, 1e-12);
    EXPECT_NEAR(result.distances(0, 1), (a - b).norm(), 1e-12);
    EXPECT_EQ(result.distances(1, 0), result.distances(0, 1));
    EXPECT_EQ(result.distance_radii(1, 0), result.distance_radii(0, 1));
    EXPECT_NEAR(result.distances(0, 0), 0.0, 1e-7);
    EXPECT_LT(result.variance_intervals[0].low, result.variances[0]);
    EXPECT_GT(result.variance_intervals[0].high, result.variances[0]);
}

TEST(GroupSpread, HoldsTheTrueDifferenceAsOftenAsItSays)
{
    int held = 0;
    constexpr int repetitions = 200;
    for (unsigned repetition = 0; repetition < repetitions; ++repetition) {
        const RowMatrix data = two_groups(100 + repetition, 1.0);
        const GroupSpread result = group_spread(inner_products(data), halves(), groups_of_one(60),
                                                {.replicates = 200, .seed = repetition});
        const Eigen::RowVectorXd difference =
            data.bottomRows(30).colwise().mean() - data.topRows(30).colwise().mean();
        held += (difference.array() - 1.0).matrix().norm() <= result.distance_radii(0, 1);
    }
    // 95 % nominally, a little less for groups of 30; the standard error is 1.5 %.
    EXPECT_GE(held, 0.89 * repetitions);
    EXPECT_LE(held, 0.99 * repetitions);
}

TEST(GroupSpread, DrawsPairsTogether)
{
    // The two states of a subject differ by the same vector: nothing is uncertain of it.
    RowMatrix data = test::random_matrix(60, 5, 2);
    std::vector<std::string> subjects;
    for (Index i = 0; i < 60; ++i)
        subjects.push_back(std::to_string(i % 30));
    data.bottomRows(30) = data.topRows(30).array() + 1.0;
    const GroupSpread paired =
        group_spread(inner_products(data), halves(), group_by(subjects), {.replicates = 50});
    EXPECT_LE(paired.distance_radii(0, 1), 1e-6);
    const GroupSpread unpaired =
        group_spread(inner_products(data), halves(), groups_of_one(60), {.replicates = 50});
    EXPECT_GT(unpaired.distance_radii(0, 1), 0.3);
}

TEST(GroupSpread, LeavesOutReplicatesWithoutAGroup)
{
    // Group c is in one of three subjects.
    const RowMatrix data = test::random_matrix(7, 3, 3);
    const GroupSpread result =
        group_spread(inner_products(data), group_by({"a", "b", "a", "b", "a", "b", "c"}),
                     group_by({"1", "1", "2", "2", "3", "3", "3"}), {.replicates = 100});
    EXPECT_TRUE(result.distance_radii.allFinite());
    EXPECT_EQ(result.variances[2], 0.0);
    EXPECT_EQ(result.variance_intervals[2].high, 0.0);
}

TEST(GroupSpread, HasTheSameBitsForAnyThreadCount)
{
    const Eigen::MatrixXd products = inner_products(two_groups(4, 1.0));
    const auto radii = [&](int threads) {
        const test::ThreadScope scope(threads);
        return group_spread(products, halves(), groups_of_one(60), {.replicates = 20})
            .distance_radii;
    };
    EXPECT_EQ(radii(1), radii(3));
}

TEST(GroupSpread, RefusesWhatBreaksARule)
{
    const Eigen::MatrixXd products = inner_products(two_groups(5, 1.0));
    EXPECT_THROW((void)group_spread(products.topRows(9), halves(), groups_of_one(60)),
                 InvalidInput);
    EXPECT_THROW((void)group_spread(products, one_group(9), groups_of_one(60)), InvalidInput);
    EXPECT_THROW((void)group_spread(products, halves(), groups_of_one(9)), InvalidInput);
    EXPECT_THROW((void)group_spread(products, halves(), groups_of_one(60), {.confidence = 1.0}),
                 InvalidInput);
}

TEST(SpreadTest, IsTheAnalysisOfVarianceOfDistancesFromTheMean)
{
    RowMatrix data = two_groups(4, 2.0);
    data.bottomRows(30) *= 1.7;
    const LinearModelTest test =
        test_spread(inner_products(data), halves(), groups_of_one(60), {.permutations = 199});
    Eigen::VectorXd distances(60);
    for (const Index start : {0, 30}) {
        const RowMatrix group = data.middleRows(start, 30);
        distances.segment(start, 30) =
            std::sqrt(30.0 / 29.0) * (group.rowwise() - group.colwise().mean()).rowwise().norm();
    }
    const double a = distances.head(30).mean();
    const double b = distances.tail(30).mean();
    const double within = (distances.head(30).array() - a).square().sum() +
                          (distances.tail(30).array() - b).square().sum();
    EXPECT_NEAR(test.f, 15.0 * (a - b) * (a - b) / (within / 58.0), 1e-8 * test.f);
    EXPECT_EQ(test.p_value, 1.0 / 200.0);
}

TEST(SpreadTest, LeavesOutGroupsWhoseMembersAreEquallyFarFromTheirMean)
{
    // Of pairs alone nothing is left; beside halves of 28 points, a pair and single ones change nothing.
    const RowMatrix data = two_groups(6, 1.0);
    std::vector<std::string> pairs, some;
    for (int i = 0; i < 60; ++i) {
        pairs.push_back(std::to_string(i / 2));
        some.push_back(i < 28 ? "a" : i < 56 ? "b" : i < 58 ? "pair" : std::to_string(i));
    }
    const PermutationOptions options{.permutations = 99};
    const LinearModelTest nothing =
        test_spread(inner_products(data), group_by(pairs), groups_of_one(60), options);
    EXPECT_EQ(nothing.permutations, 0);
    EXPECT_EQ(nothing.p_value, 1.0);
    EXPECT_EQ(nothing.degrees_of_freedom, 0);
    const LinearModelTest found =
        test_spread(inner_products(data), group_by(some), groups_of_one(60), options);
    some.resize(56);
    const LinearModelTest alone =
        test_spread(inner_products(data.topRows(56)), group_by(some), groups_of_one(56), options);
    EXPECT_NEAR(found.f, alone.f, 1e-9 * alone.f);
    EXPECT_EQ(found.p_value, alone.p_value);
    EXPECT_EQ(found.residual_degrees_of_freedom, 54);
}

TEST(SpreadTest, FindsNothingWhereOnlyTheMeansDiffer)
{
    int found = 0;
    for (unsigned seed = 0; seed < 100; ++seed)
        found += test_spread(inner_products(two_groups(300 + seed, 3.0)), halves(),
                             groups_of_one(60), {.permutations = 99, .seed = seed})
                     .p_value <= 0.05;
    EXPECT_LE(found, 12); // 5 expected, standard error 2.2
    // Means of blocks count once: three scans of each of twenty subjects.
    std::vector<std::string> subjects;
    for (int i = 0; i < 60; ++i)
        subjects.push_back(std::to_string(i / 3));
    EXPECT_EQ(test_spread(inner_products(two_groups(5, 1.0)), halves(), group_by(subjects),
                          {.permutations = 9})
                  .residual_degrees_of_freedom,
              18);
}

} // namespace
} // namespace shape
