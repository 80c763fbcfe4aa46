// SPDX-License-Identifier: MIT

#include "libshape/statistics/linear_model.h"

#include <gtest/gtest.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "libshape/base/error.h"
#include "libshape/base/random.h"
#include "libshape/base/to_size.h"
#include "libshape/statistics/inner_products.h"
#include "tests/support/matrices.h"
#include "tests/support/thread_scope.h"
#include "tests/support/uniformity.h"

namespace shape {
using namespace internal;
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

const MatrixXd no_columns(Index rows)
{
    return MatrixXd(rows, 0);
}

/// A test without nuisance.
LinearModelTest test_groups(const RowMatrix& data, const std::vector<std::string>& groups,
                            const Grouping& blocks, const PermutationOptions& options = {})
{
    return test_linear_model(inner_products(data), indicators(group_by(groups)),
                             no_columns(data.rows()), blocks, options);
}

/// Sum of squares of what least squares on the columns leaves over.
double residual_squares(const MatrixXd& data, const MatrixXd& columns)
{
    return (data - columns * columns.completeOrthogonalDecomposition().solve(data)).squaredNorm();
}

MatrixXd joined(const MatrixXd& a, const MatrixXd& b)
{
    MatrixXd result(a.rows(), a.cols() + b.cols());
    result << a, b;
    return result;
}

TEST(LinearModel, OfOneVariableInGroupsIsTheAnalysisOfVariance)
{
    const RowMatrix data{{1}, {2}, {3}, {2}, {3}, {4}, {5}, {6}, {7}};
    const LinearModelTest result =
        test_groups(data, {"a", "a", "a", "b", "b", "b", "c", "c", "c"}, one_group(9));
    EXPECT_NEAR(result.sum_of_squares, 26.0, 1e-12);
    EXPECT_NEAR(result.residual_sum_of_squares, 6.0, 1e-12);
    EXPECT_NEAR(result.total_sum_of_squares, 32.0, 1e-12);
    EXPECT_EQ(result.degrees_of_freedom, 2);
    EXPECT_EQ(result.residual_degrees_of_freedom, 6);
    EXPECT_NEAR(result.f, 13.0, 1e-11);
    EXPECT_NEAR(result.r_squared, 26.0 / 32.0, 1e-13);
    EXPECT_EQ(result.permutations, 999);
}

TEST(LinearModel, OfDistancesHasTheSumsOfSquaresOfAnderson)
{
    // City block distances: no points of a Euclidean space have them.
    const RowMatrix data = test::random_matrix(12, 4, 1);
    MatrixXd distances(12, 12);
    for (Index i = 0; i < 12; ++i)
        for (Index j = 0; j < 12; ++j)
            distances(i, j) = (data.row(i) - data.row(j)).lpNorm<1>();
    const std::vector<std::string> groups{"a", "b", "a", "c", "c", "b",
                                          "a", "b", "a", "c", "a", "b"};
    const std::vector<double> sizes{5.0, 4.0, 3.0};
    double total = 0.0;
    double within = 0.0;
    const Grouping grouping = group_by(groups);
    for (std::size_t i = 0; i < 12; ++i)
        for (std::size_t j = 0; j < i; ++j) {
            const double square =
                std::pow(distances(static_cast<Index>(i), static_cast<Index>(j)), 2);
            total += square / 12.0;
            if (groups[i] == groups[j])
                within += square / sizes[to_size(grouping.group_of[i])];
        }
    const LinearModelTest result =
        test_linear_model(inner_products_of_distances(distances), indicators(grouping),
                          no_columns(12), one_group(12));
    EXPECT_NEAR(result.total_sum_of_squares, total, 1e-11);
    EXPECT_NEAR(result.residual_sum_of_squares, within, 1e-11);
    EXPECT_NEAR(result.f, ((total - within) / 2.0) / (within / 9.0), 1e-11);
}

TEST(LinearModel, OfPairsIsTheSquareOfThePairedT)
{
    const RowMatrix data{{1.0}, {1.5}, {4.0}, {4.2}, {2.0}, {2.9}, {7.0}, {7.7}};
    const LinearModelTest result = test_groups(data, {"a", "b", "a", "b", "a", "b", "a", "b"},
                                               group_by({"1", "1", "2", "2", "3", "3", "4", "4"}));
    const Eigen::Vector4d change(0.5, 0.2, 0.9, 0.7);
    const double variance = (change.array() - change.mean()).square().sum() / 3.0;
    EXPECT_NEAR(result.f, change.mean() * change.mean() / (variance / 4.0), 1e-10);
    EXPECT_EQ(result.residual_degrees_of_freedom, 3);
}

TEST(LinearModel, OnACovariateHasTheSquaredCorrelation)
{
    const RowMatrix data = test::random_matrix(20, 1, 2);
    const MatrixXd covariate = 100.0 + test::random_matrix(20, 1, 3).array();
    const LinearModelTest result =
        test_linear_model(inner_products(data), covariate, no_columns(20), one_group(20));
    const Eigen::VectorXd y = data.col(0).array() - data.col(0).mean();
    const Eigen::VectorXd x = covariate.col(0).array() - covariate.col(0).mean();
    const double r = x.dot(y) / (x.norm() * y.norm());
    EXPECT_NEAR(result.r_squared, r * r, 1e-13);
    EXPECT_NEAR(result.f, r * r / (1.0 - r * r) * 18.0, 1e-11);
}

TEST(LinearModel, OfTestedColumnsBeyondOthersComparesTwoLeastSquaresFits)
{
    const RowMatrix data = test::random_matrix(30, 7, 4);
    const MatrixXd tested = test::random_matrix(30, 2, 5);
    MatrixXd nuisance = test::random_matrix(30, 3, 6);
    nuisance.col(2) = 2.0 * nuisance.col(0) - nuisance.col(1); // of rank 2
    std::vector<std::string> labels;
    for (int i = 0; i < 30; ++i)
        labels.push_back(std::to_string(i % 4));
    const Grouping blocks = group_by(labels);
    const LinearModelTest result =
        test_linear_model(inner_products(data), tested, nuisance, blocks);
    const MatrixXd reduced = joined(indicators(blocks), nuisance);
    const double left = residual_squares(data, reduced);
    const double least = residual_squares(data, joined(reduced, tested));
    EXPECT_NEAR(result.sum_of_squares, left - least, 1e-11);
    EXPECT_NEAR(result.residual_sum_of_squares, least, 1e-11);
    EXPECT_EQ(result.degrees_of_freedom, 2);
    EXPECT_EQ(result.residual_degrees_of_freedom, 30 - 4 - 2 - 2);
}

TEST(LinearModel, CountsThePermutationsThatExplainAsMuch)
{
    // Of the 20 ways to choose three of six, these and their complements explain the most: p = 0.1.
    const RowMatrix data{{1}, {2}, {3}, {11}, {12}, {13}};
    const LinearModelTest result =
        test_groups(data, {"a", "a", "a", "b", "b", "b"}, one_group(6), {.permutations = 9999});
    EXPECT_NEAR(result.p_value, 0.1, 5.0 * std::sqrt(0.1 * 0.9 / 9999.0));
    EXPECT_TRUE(std::isnan(
        test_groups(data, {"a", "a", "a", "b", "b", "b"}, one_group(6), {.permutations = 0})
            .p_value));
}

/// The share of all permutations within the blocks whose F is the largest, of points in general position.
double share_of_largest(const MatrixXd& tested, const MatrixXd& nuisance, const Grouping& blocks)
{
    const Index count = tested.rows();
    const RowMatrix data = test::random_matrix(count, count, 5);
    std::vector<int> order(to_size(count));
    std::iota(order.begin(), order.end(), 0);
    std::vector<double> ratios;
    do {
        bool stays = true;
        for (std::size_t i = 0; i < order.size(); ++i)
            stays = stays && blocks.group_of[i] == blocks.group_of[to_size(order[i])];
        if (stays)
            ratios.push_back(test_linear_model(inner_products(data), tested(order, Eigen::all),
                                               nuisance(order, Eigen::all), blocks,
                                               {.permutations = 0})
                                 .f);
    } while (std::ranges::next_permutation(order).found);
    const double largest = *std::ranges::max_element(ratios);
    const auto as_large =
        std::ranges::count_if(ratios, [&](double f) { return f > largest * (1.0 - 1e-9); });
    return static_cast<double>(as_large) / static_cast<double>(ratios.size());
}

TEST(LinearModel, KnowsTheSmallestPValueOfADesign)
{
    const auto groups = [](const std::vector<std::string>& of) -> MatrixXd {
        return indicators(group_by(of));
    };
    const Grouping pairs = group_by({"x", "x", "y", "y", "z", "z"});
    struct Case
    {
        MatrixXd tested;
        Grouping blocks;
        double smallest;
    };
    for (const auto& [tested, blocks, smallest] : std::vector<Case>{
             {groups({"a", "a", "a", "b", "b", "b"}), one_group(6), 0.1},
             {groups({"a", "a", "b", "b", "b", "b"}), one_group(6), 1.0 / 15.0},
             {groups({"a", "a", "b", "b", "c", "c"}), one_group(6), 1.0 / 15.0}, // 90 / 3!
             {groups({"a", "a", "a", "b", "b", "c"}), one_group(6), 1.0 / 60.0},
             {groups({"a", "b", "a", "b", "a", "b"}), pairs, 0.25}, // 8 / 2
             {groups({"a", "b", "a", "b", "b", "b"}), pairs, 0.5},  // z says nothing
             {Eigen::VectorXd::LinSpaced(6, 1.0, 6.0), one_group(6), 2.0 / 720.0},
             {Eigen::VectorXd{{1.0, 2.0, 3.0, 4.0, 5.0, 7.0}}, one_group(6), 1.0 / 720.0},
             {Eigen::VectorXd{{1.0, 2.0, 3.0, 5.0, 7.0, 7.0}}, pairs, 0.5}}) {
        const LinearModelTest result =
            test_linear_model(inner_products(test::random_matrix(6, 6, 5)), tested, no_columns(6),
                              blocks, {.permutations = 9});
        EXPECT_NEAR(result.smallest_p, smallest, 1e-15);
        EXPECT_NEAR(result.smallest_p, share_of_largest(tested, no_columns(6), blocks), 1e-15);
    }
    // With nuisance whose values come twice.
    const MatrixXd other = Eigen::VectorXd{{1.0, 1.0, 2.0, 2.0, 4.0, 4.0}};
    EXPECT_NEAR(test_linear_model(inner_products(test::random_matrix(6, 6, 5)),
                                  groups({"a", "a", "a", "b", "b", "b"}), other, one_group(6))
                    .smallest_p,
                1.0 / 180.0, 1e-15); // 6! / (2! 2!): the first two are alike, and the last two
    // A column that is constant, in all or in each block, changes nothing.
    for (const MatrixXd& constant : std::vector<MatrixXd>{
             Eigen::VectorXd::Constant(6, 3.7), Eigen::VectorXd{{0.1, 0.1, 7.0, 7.0, 0.3, 0.3}}}) {
        const bool is_of_blocks = constant(2) != constant(0);
        const MatrixXd tested = groups({"a", "b", "a", "b", "a", "b"});
        const Grouping blocks = is_of_blocks ? pairs : one_group(6);
        const LinearModelTest result =
            test_linear_model(inner_products(test::random_matrix(6, 6, 5)), tested, constant,
                              blocks, {.permutations = 0});
        EXPECT_NEAR(result.smallest_p, is_of_blocks ? 0.25 : 0.1, 1e-15);
        EXPECT_NEAR(result.smallest_p, share_of_largest(tested, constant, blocks), 1e-15);
    }
    // Others change it to what counting gives.
    struct Adjusted
    {
        MatrixXd tested, nuisance;
        Grouping blocks;
        double smallest;
    };
    const std::vector<std::string> sexes{"f", "f", "m", "f", "m", "m"};
    for (
        const auto& [tested, nuisance, blocks, smallest] : std::vector<Adjusted>{
            // Each group has two of one sex and one of the other: the groups may change their names, if the sexes do.
            {groups({"a", "a", "a", "b", "b", "b"}), groups(sexes), one_group(6), 2.0 / 180.0},
            // Balanced but for one: none may.
            {groups({"a", "a", "a", "b", "b", "b"}), groups({"f", "f", "m", "f", "f", "m"}),
             one_group(6), 2.0 / 180.0},
            {groups({"a", "a", "a", "b", "b", "b"}), groups({"f", "f", "m", "f", "f", "f"}),
             one_group(6), 1.0 / 60.0},
            // Two covariates that are mirror images together, and two that are by different places.
            {Eigen::VectorXd{{1.0, 2.0, 3.0, 4.0, 5.0, 6.0}},
             Eigen::VectorXd{{3.0, 9.0, 1.0, 1.0, 9.0, 3.0}}, one_group(6), 2.0 / 720.0},
            {Eigen::VectorXd{{1.0, 2.0, 3.0, 4.0, 5.0, 6.0}},
             Eigen::VectorXd{{3.0, 9.0, 1.0, 9.0, 1.0, 3.0}}, one_group(6), 1.0 / 720.0},
            // The corners of a hexagon, which six turns and six mirrors keep.
            {joined(Eigen::VectorXd{{2.0, 1.0, -1.0, -2.0, -1.0, 1.0}},
                    Eigen::VectorXd{{0.0, 1.0, 1.0, 0.0, -1.0, -1.0}} * std::sqrt(3.0)),
             no_columns(6), one_group(6), 12.0 / 720.0},
            {groups({"a", "b", "a", "b", "a", "b"}),
             Eigen::VectorXd{{1.0, 2.0, 2.0, 4.0, 3.0, 7.0}}, pairs, 0.25}}) {
        const LinearModelTest result =
            test_linear_model(inner_products(test::random_matrix(6, 6, 5)), tested, nuisance,
                              blocks, {.permutations = 0});
        EXPECT_NEAR(result.smallest_p, share_of_largest(tested, nuisance, blocks), 1e-15);
        EXPECT_NEAR(result.smallest_p, smallest, 1e-15);
    }
    // Forty groups of two: 80! / 2^40 permutations, 40! of which but change names.
    std::vector<std::string> many;
    double logarithm = 0.0;
    for (int i = 0; i < 40; ++i)
        many.insert(many.end(), 2, std::to_string(i));
    for (int i = 1; i <= 40; ++i)
        logarithm += 2.0 * std::log(i) - std::log(2.0 * i - 1.0) - std::log(2.0 * i) - std::log(i) +
                     std::log(2.0);
    EXPECT_NEAR(
        std::log(test_linear_model(inner_products(test::random_matrix(80, 3, 1)), groups(many),
                                   no_columns(80), one_group(80), {.permutations = 0})
                     .smallest_p),
        logarithm, 1e-10);
    // Of many no share is left that a double could hold.
    EXPECT_EQ(test_linear_model(inner_products(test::random_matrix(300, 4, 1)),
                                Eigen::VectorXd(test::random_matrix(300, 1, 2)), no_columns(300),
                                one_group(300), {.permutations = 1})
                  .smallest_p,
              0.0);
}

TEST(LinearModel, TakesTheSmallestPValueForTheLargestF)
{
    RowMatrix data = 0.001 * test::random_matrix(6, 3, 1);
    data.bottomRows(3).array() += 1.0;
    const LinearModelTest result =
        test_groups(data, {"a", "a", "a", "b", "b", "b"}, one_group(6), {.permutations = 20'000});
    EXPECT_NEAR(result.p_value, result.smallest_p, 5.0 * std::sqrt(0.1 * 0.9 / 20'000.0));
}

TEST(LinearModel, HasNoPValueBelowWhatTheDesignAllows)
{
    RowMatrix data = 0.001 * test::random_matrix(6, 3, 1);
    data.bottomRows(3).array() += 1.0;
    for (std::uint64_t seed = 1; seed <= 40; ++seed)
        for (const int permutations : {19, 99})
            EXPECT_GE(test_groups(data, {"a", "a", "a", "b", "b", "b"}, one_group(6),
                                  {.permutations = permutations, .seed = seed})
                          .p_value,
                      0.1);
}

TEST(LinearModel, PermutesWithinBlocksAlone)
{
    // Each of three pairs can be swapped: two of the eight arrangements have all changes alike.
    const RowMatrix data{{0}, {1}, {10}, {11.1}, {20}, {21.2}};
    const LinearModelTest result =
        test_groups(data, {"a", "b", "a", "b", "a", "b"}, group_by({"1", "1", "2", "2", "3", "3"}),
                    {.permutations = 9999});
    EXPECT_NEAR(result.p_value, 0.25, 5.0 * std::sqrt(0.25 * 0.75 / 9999.0));
}

TEST(LinearModel, PermutesResidualsOfTheNuisance)
{
    // An independent Freedman-Lane permutation test of one covariate beyond another.
    const Index count = 25;
    const MatrixXd nuisance = test::random_matrix(count, 1, 7);
    const MatrixXd tested = nuisance + 0.7 * test::random_matrix(count, 1, 8);
    const MatrixXd data = nuisance * MatrixXd{{3.0, -1.0}} + 0.35 * tested * MatrixXd{{1.0, 0.2}} +
                          test::random_matrix(count, 2, 9);
    const MatrixXd reduced = joined(MatrixXd::Ones(count, 1), nuisance);
    const MatrixXd full = joined(reduced, tested);
    const auto f = [&](const MatrixXd& y) {
        const double least = residual_squares(y, full);
        return (residual_squares(y, reduced) - least) / least;
    };
    const MatrixXd fitted = reduced * reduced.completeOrthogonalDecomposition().solve(data);
    const MatrixXd residuals = data - fitted;
    Random random(10);
    int extreme = 0;
    constexpr int permutations = 2000;
    for (int k = 0; k < permutations; ++k) {
        std::vector<int> order(to_size(count));
        std::iota(order.begin(), order.end(), 0);
        for (std::size_t i = order.size(); i > 1; --i)
            std::swap(order[i - 1], order[random.index(i)]);
        extreme += f(fitted + residuals(order, Eigen::all)) >= f(data);
    }
    const double expected = (1.0 + extreme) / (1.0 + permutations);
    const LinearModelTest result = test_linear_model(
        inner_products(data), tested, nuisance, one_group(count), {.permutations = permutations});
    ASSERT_GT(expected, 0.01);
    ASSERT_LT(expected, 0.5);
    EXPECT_NEAR(result.p_value, expected, 5.0 * std::sqrt(2.0 * expected / permutations));
}

TEST(LinearModel, HasUniformProbabilitiesIfThereIsNothingToFind)
{
    const RowMatrix data = test::random_matrix(40, 5, 11);
    const MatrixXd products = inner_products(data);
    std::vector<std::string> subjects;
    for (int i = 0; i < 40; ++i)
        subjects.push_back(std::to_string(i / 4));
    for (const Grouping& blocks : {one_group(40), group_by(subjects)}) {
        std::vector<double> p_values;
        for (unsigned repetition = 0; repetition < 200; ++repetition) {
            const MatrixXd tested = test::random_matrix(40, 1, 100 + repetition);
            p_values.push_back(test_linear_model(products, tested, no_columns(40), blocks,
                                                 {.permutations = 199, .seed = repetition})
                                   .p_value);
        }
        EXPECT_LT(test::kolmogorov_smirnov(p_values), 1.63);
    }
}

TEST(LinearModel, DoesNotDependOnTheOriginOrTheThreads)
{
    const RowMatrix data = test::random_matrix(40, 6, 12);
    const RowMatrix moved = data.rowwise() + test::random_matrix(1, 6, 13).row(0);
    const MatrixXd tested = test::random_matrix(40, 2, 14);
    const auto result = [&](const RowMatrix& points, int threads) {
        const test::ThreadScope scope(threads);
        return test_linear_model(inner_products(points), tested, no_columns(40), one_group(40));
    };
    const LinearModelTest one = result(data, 1);
    const LinearModelTest three = result(data, 3);
    EXPECT_EQ(one.f, three.f);
    EXPECT_EQ(one.p_value, three.p_value);
    EXPECT_NEAR(result(moved, 2).f, one.f, 1e-11);
    EXPECT_EQ(result(moved, 2).p_value, one.p_value);
}

TEST(LinearModel, OfAPerfectFitHasNothingLeftOver)
{
    const MatrixXd tested = test::random_matrix(8, 1, 15);
    const LinearModelTest result = test_linear_model(inner_products(tested * MatrixXd{{2.0, 1.0}}),
                                                     tested, no_columns(8), one_group(8));
    EXPECT_EQ(result.f, std::numeric_limits<double>::infinity());
    EXPECT_NEAR(result.r_squared, 1.0, 1e-13);
    EXPECT_EQ(result.p_value, 0.001);
}

TEST(LinearModel, RefusesWhatBreaksARule)
{
    const MatrixXd products = inner_products(test::random_matrix(6, 3, 16));
    const MatrixXd tested = test::random_matrix(6, 1, 17);
    const auto test = [&](const MatrixXd& g, const MatrixXd& x, const MatrixXd& z,
                          const Grouping& blocks, int permutations = 9) {
        return test_linear_model(g, x, z, blocks, {.permutations = permutations});
    };
    const Grouping one = one_group(6);
    EXPECT_NO_THROW((void)test(products, tested, no_columns(6), one));
    EXPECT_THROW((void)test(products.topRows(5), tested, no_columns(6), one), InvalidInput);
    EXPECT_THROW((void)test(products, tested.topRows(5), no_columns(6), one), InvalidInput);
    EXPECT_THROW((void)test(products, no_columns(6), no_columns(6), one), InvalidInput);
    EXPECT_THROW((void)test(products, tested, no_columns(5), one), InvalidInput);
    EXPECT_THROW((void)test(products, tested, no_columns(6), one_group(5)), InvalidInput);
    EXPECT_THROW((void)test(products, tested, no_columns(6), one, -1), InvalidInput);
    MatrixXd infinite = tested;
    infinite(2, 0) = std::numeric_limits<double>::infinity();
    EXPECT_THROW((void)test(products, infinite, no_columns(6), one), InvalidInput);
    // Nothing tested, nothing left, nothing varies.
    EXPECT_THROW((void)test(products, MatrixXd::Ones(6, 1), no_columns(6), one), InvalidInput);
    EXPECT_THROW((void)test(products, tested, 3.0 * tested, one), InvalidInput);
    EXPECT_THROW((void)test(products, tested, test::random_matrix(6, 4, 18), one), InvalidInput);
    EXPECT_THROW((void)test(MatrixXd::Zero(6, 6), tested, no_columns(6), one), InvalidInput);
}

} // namespace
} // namespace shape
