// SPDX-License-Identifier: MIT

#include "libshape/statistics/block_slopes.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>

#include "libshape/base/error.h"
#include "libshape/base/random.h"
#include "libshape/base/threads.h"
#include "libshape/statistics/covariate_blocks.h"
#include "libshape/statistics/inner_products.h"
#include "tests/support/files.h"
#include "tests/support/matrices.h"

namespace shape {
using namespace internal;
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

/// People at some ages; each grows a way of his own, which is nothing on average.
struct People
{
    RowMatrix data;
    MatrixXd ages;
    Grouping blocks;
};

People grown(int people, int visits, double own_growth, double growth, Random& random)
{
    People result{RowMatrix(people * visits, 3), MatrixXd(people * visits, 1), {}};
    std::vector<std::string> names;
    for (int p = 0; p < people; ++p) {
        Eigen::RowVector3d slope = Eigen::RowVector3d::Constant(growth);
        for (double& x : slope)
            x += own_growth * random.normal();
        const double first = random.uniform(20.0, 60.0);
        for (int v = 0; v < visits; ++v) {
            const Index row = p * visits + v;
            result.ages(row, 0) = first + v;
            for (Index k = 0; k < 3; ++k)
                result.data(row, k) = 10.0 * p + slope[k] * v + random.normal();
            names.push_back(std::to_string(p));
        }
    }
    result.blocks = group_by(names);
    return result;
}

LinearModelTest test_of(const People& people, const PermutationOptions& options)
{
    return test_slopes(inner_products(people.data), people.ages, MatrixXd(people.ages.rows(), 0),
                       people.blocks, options);
}

TEST(BlockSlopes, AreTestedAgainstTheirDifferences)
{
    // Slopes of ordinary least squares in each block; their contributions to the common one.
    Random random(3);
    const People people = grown(6, 4, 0.5, 0.3, random);
    const LinearModelTest test = test_of(people, {.permutations = 0});
    Eigen::RowVector3d sum = Eigen::RowVector3d::Zero();
    double squares = 0.0;
    double slopes = 0.0;
    for (Index p = 0; p < 6; ++p) {
        const RowMatrix rows = people.data.middleRows(4 * p, 4);
        Eigen::VectorXd age = people.ages.col(0).segment(4 * p, 4);
        age.array() -= age.mean();
        const Eigen::RowVector3d own = age.transpose() * rows;
        sum += own;
        squares += age.squaredNorm();
        slopes += own.squaredNorm() / age.squaredNorm();
    }
    const double explained = sum.squaredNorm() / squares;
    EXPECT_NEAR(test.sum_of_squares, explained, 1e-9);
    EXPECT_NEAR(test.residual_sum_of_squares, slopes - explained, 1e-9);
    EXPECT_EQ(test.residual_degrees_of_freedom, 5);
    EXPECT_NEAR(test.f, explained / ((slopes - explained) / 5.0), 1e-9);
    const LinearModelTest plain =
        test_linear_model(inner_products(people.data), people.ages, MatrixXd(24, 0), people.blocks,
                          {.permutations = 0});
    EXPECT_EQ(test.r_squared, plain.r_squared);
    EXPECT_EQ(test.smallest_p, 1.0 / 32.0);
}

TEST(BlockSlopes, OfTwoRowsEachAreTheDifferencesOfPairs)
{
    Random random(4);
    const People people = grown(9, 2, 0.5, 0.2, random);
    const LinearModelTest slopes = test_of(people, {.permutations = 9999});
    const LinearModelTest pairs =
        test_linear_model(inner_products(people.data), people.ages, MatrixXd(18, 0), people.blocks,
                          {.permutations = 9999});
    EXPECT_NEAR(slopes.f, pairs.f, 1e-9 * pairs.f);
    EXPECT_EQ(slopes.residual_degrees_of_freedom, pairs.residual_degrees_of_freedom);
    EXPECT_NEAR(slopes.p_value, pairs.p_value, 0.02);
    const ExchangeableRows rows =
        exchangeable_rows(inner_products(people.data), people.ages, people.blocks);
    EXPECT_FALSE(compares_slopes(rows));
    EXPECT_EQ(test_covariates(rows, rows.covariates, MatrixXd(18, 0), {.permutations = 99}).p_value,
              test_linear_model(inner_products(people.data), people.ages, MatrixXd(18, 0),
                                people.blocks, {.permutations = 99})
                  .p_value);
}

/// Growth that differs between people and is nothing on average is found no oftener than chance has it, one that
/// all have is found.
TEST(BlockSlopes, KeepTheLevelWhereSlopesDifferBetweenBlocks)
{
    Random random(7);
    int of_slopes = 0;
    int of_any = 0;
    int common = 0;
    for (unsigned round = 0; round < 200; ++round) {
        const PermutationOptions options{.permutations = 199, .seed = round};
        const People none = grown(10, 5, 1.0, 0.0, random);
        of_slopes += test_of(none, options).p_value <= 0.05 ? 1 : 0;
        of_any += test_linear_model(inner_products(none.data), none.ages, MatrixXd(50, 0),
                                    none.blocks, options)
                              .p_value <= 0.05
                      ? 1
                      : 0;
        common += test_of(grown(10, 5, 0.0, 0.3, random), options).p_value <= 0.05 ? 1 : 0;
    }
    EXPECT_LE(of_slopes, 20); // of 200 at 5 %: more with probability 0.001
    EXPECT_GE(of_any, 80);
    EXPECT_GE(common, 180);
}

TEST(BlockSlopes, KeepTheLevelBeyondOtherCovariatesWhoseSlopesDiffer)
{
    Random random(8);
    int found = 0;
    for (unsigned round = 0; round < 200; ++round) {
        People people = grown(10, 5, 1.0, 0.5, random); // by age, which is nuisance here
        MatrixXd dose = test::random_matrix(50, 1, 100 + round);
        for (Index p = 0; p < 10; ++p) {
            const Eigen::RowVector3d own =
                test::random_matrix(1, 3, 1000 + 10 * round + static_cast<unsigned>(p));
            people.data.middleRows(5 * p, 5) += dose.middleRows(5 * p, 5) * own;
        }
        dose += 0.5 * people.ages;
        found += test_slopes(inner_products(people.data), dose, people.ages, people.blocks,
                             {.permutations = 199, .seed = round})
                             .p_value <= 0.05
                     ? 1
                     : 0;
    }
    EXPECT_LE(found, 20);
}

TEST(BlockSlopes, OfSeveralCovariatesAreTestedTogether)
{
    Random random(9);
    const People people = grown(8, 4, 0.3, 0.5, random);
    MatrixXd both(32, 2);
    both << people.ages, test::random_matrix(32, 1, 5);
    const MatrixXd products = inner_products(people.data);
    const MatrixXd none(32, 0);
    const auto test = [&](const MatrixXd& columns) {
        return test_slopes(products, columns, none, people.blocks, {.permutations = 99});
    };
    const LinearModelTest found = test(both);
    EXPECT_EQ(found.degrees_of_freedom, 2);
    EXPECT_EQ(found.residual_degrees_of_freedom, 14);
    // The same plane in other columns.
    MatrixXd mixed = both;
    mixed.col(1) += 3.0 * both.col(0);
    EXPECT_NEAR(test(mixed).f, found.f, 1e-8 * found.f);
    EXPECT_EQ(test(mixed).p_value, found.p_value);
}

TEST(BlockSlopes, HaveTheSameBitsForAnyNumberOfThreads)
{
    Random random(10);
    const People people = grown(12, 5, 0.5, 0.1, random);
    const int threads = thread_count();
    set_thread_count(1);
    const double one = test_of(people, {.permutations = 999}).p_value;
    set_thread_count(3);
    EXPECT_EQ(test_of(people, {.permutations = 999}).p_value, one);
    set_thread_count(threads);
}

TEST(BlockSlopes, OfOneBlockHaveNothingToDifferFrom)
{
    const RowMatrix data = test::random_matrix(9, 2, 11);
    const MatrixXd ages{{1}, {2}, {3}, {4}, {4}, {4}, {7}, {7}, {7}};
    const std::string message = test::message_of<InvalidInput>([&] {
        (void)test_slopes(inner_products(data), ages, MatrixXd(9, 0),
                          group_by({"x", "x", "x", "y", "y", "y", "z", "z", "z"}), {});
    });
    EXPECT_EQ(message,
              "slopes: what is tested varies in 1 of 3 blocks, too few to tell how much "
              "slopes differ between blocks");
}

} // namespace
} // namespace shape
