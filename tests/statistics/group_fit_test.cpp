// SPDX-License-Identifier: MIT

#include "libshape/statistics/group_fit.h"

#include <gtest/gtest.h>

#include <Eigen/QR>
#include <limits>

#include "libshape/base/error.h"
#include "libshape/base/to_size.h"
#include "tests/support/matrices.h"

namespace shape::internal {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using Labels = std::vector<std::string>;

GroupFit fit_of(const Labels& groups, const Labels& blocks, const MatrixXd& covariates)
{
    return {group_by(groups), group_by(blocks), covariates};
}

GroupFit fit_of(const Labels& groups, const Labels& blocks)
{
    return fit_of(groups, blocks, MatrixXd(static_cast<Index>(groups.size()), 0));
}

void expect_weights(const GroupFit& fit, const MatrixXd& expected)
{
    ASSERT_EQ(fit.means().rows(), expected.rows());
    EXPECT_LE((fit.means() - expected).cwiseAbs().maxCoeff(), 1e-15) << fit.means();
}

TEST(GroupFit, IsOfAllMembersWithoutBlocks)
{
    const GroupFit fit = fit_of({"a", "b", "a"}, {"1", "2", "3"});
    EXPECT_TRUE(fit.is_plain());
    expect_weights(fit, (MatrixXd(3, 2) << 0.5, 0, 0, 1, 0.5, 0).finished());
}

TEST(GroupFit, CountsABlockOfOneGroupOnce)
{
    // Three scans of one person, one of another; b has one person.
    const GroupFit fit = fit_of({"a", "a", "b", "a", "a", "b"}, {"1", "1", "3", "2", "1", "3"});
    EXPECT_EQ(fit.rows().design, BlockDesign::Nested);
    EXPECT_EQ(fit.rows().observations.count, 3);
    EXPECT_FALSE(fit.is_plain());
    const double third = 1.0 / 6.0;
    expect_weights(
        fit, (MatrixXd(6, 2) << third, 0, third, 0, 0, 0.5, 0.5, 0, third, 0, 0, 0.5).finished());
}

TEST(GroupFit, CountsABlockOfSeveralGroupsOnceInEach)
{
    // Person 1 three times before and once after, person 2 once each; person 3 before alone.
    const GroupFit fit = fit_of({"pre", "pre", "pre", "post", "pre", "post", "pre"},
                                {"1", "1", "1", "1", "2", "2", "3"});
    EXPECT_EQ(fit.rows().design, BlockDesign::Crossed);
    EXPECT_EQ(fit.rows().observations.points, (std::vector<int>{0, 1, 2, 3, 4, 5}));
    EXPECT_TRUE(fit.is_direct());
    const double sixth = 1.0 / 6.0;
    expect_weights(
        fit,
        (MatrixXd(7, 2) << sixth, 0, sixth, 0, sixth, 0, 0, 0.5, 0.5, 0, 0, 0.5, 0, 0).finished());
}

TEST(GroupFit, KeepsGroupsThatNoBlockComparesAtTheirOwnBlocks)
{
    const GroupFit fit =
        fit_of({"a", "b", "a", "b", "c", "c", "c", "a"}, {"1", "1", "2", "2", "3", "3", "4", "5"});
    EXPECT_TRUE(fit.is_direct());
    VectorXd c(8);
    c << 0, 0, 0, 0, 0.25, 0.25, 0.5, 0;
    EXPECT_LE((fit.means().col(2) - c).norm(), 1e-15);
    EXPECT_EQ(fit.means()(7, 0), 0.0);
}

/// Rows of groups, blocks and covariates, and a model of them in dummy variables.
struct Model
{
    Labels groups, blocks;
    MatrixXd covariates;
    MatrixXd columns; ///< Groups, covariates about the means that count, and, crossed, blocks.
};

/// 15 observations in three groups of unequal covariates.
Model uncrossed()
{
    Model model;
    model.covariates = test::random_matrix(15, 2, 1);
    model.columns = MatrixXd::Zero(15, 5);
    for (Index i = 0; i < 15; ++i) {
        const Index group = i % 7 % 3;
        model.groups.push_back(std::string(1, "abc"[group]));
        model.blocks.push_back(std::to_string(i));
        model.covariates(i, 0) += 2.0 * static_cast<double>(group);
        model.columns(i, group) = 1.0;
    }
    model.columns.rightCols(2) = model.covariates.rowwise() - model.covariates.colwise().mean();
    return model;
}

/// Seven blocks of three groups, of which two lack one, and covariates that differ within the blocks.
Model crossed(Index covariates)
{
    Model model;
    for (int block = 0; block < 7; ++block)
        for (int group = 0; group < 3; ++group)
            if (!(block == 2 && group == 0) && !(block == 4 && group == 1)) {
                model.groups.push_back(std::string(1, "abc"[group]));
                model.blocks.push_back(std::to_string(block));
            }
    model.covariates = test::random_matrix(19, covariates, 2);
    const MatrixXd groups = indicators(group_by(model.groups));
    const MatrixXd blocks = indicators(group_by(model.blocks));
    const VectorXd shares = blocks * blocks.colwise().sum().cwiseInverse().transpose() / 7.0;
    model.columns.resize(19, 3 + covariates + 7);
    model.columns << groups, model.covariates.rowwise() - shares.transpose() * model.covariates,
        blocks;
    return model;
}

/// What least squares expects of each group at the means of the covariates and of the blocks.
MatrixXd expected_means(const Model& model, const VectorXd& times, const MatrixXd& data)
{
    const VectorXd roots = times.cwiseSqrt();
    const MatrixXd coefficients = (roots.asDiagonal() * model.columns)
                                      .completeOrthogonalDecomposition()
                                      .solve(roots.asDiagonal() * data);
    MatrixXd places = MatrixXd::Zero(3, model.columns.cols());
    places.leftCols(3).setIdentity();
    const Index blocks = model.columns.cols() - 3 - model.covariates.cols();
    if (blocks > 0) {
        const auto of_blocks = model.columns.rightCols(blocks);
        VectorXd drawn(blocks);
        for (Index b = 0; b < blocks; ++b)
            drawn[b] = times.dot(of_blocks.col(b)) / of_blocks.col(b).sum();
        places.rightCols(blocks).rowwise() = drawn.transpose() / drawn.sum();
    }
    return places * coefficients;
}

TEST(GroupFit, HasLeastSquaresMeans)
{
    for (const Model& model : {uncrossed(), crossed(0), crossed(1), crossed(2)}) {
        const GroupFit fit = fit_of(model.groups, model.blocks, model.covariates);
        EXPECT_FALSE(fit.is_direct());
        const auto count = static_cast<Index>(model.groups.size());
        const MatrixXd data = test::random_matrix(count, 4, 3);
        const MatrixXd expected = expected_means(model, VectorXd::Ones(count), data);
        EXPECT_LE((fit.means().transpose() * data - expected).cwiseAbs().maxCoeff(), 1e-12);
        EXPECT_LE((fit.means().colwise().sum().array() - 1.0).abs().maxCoeff(), 1e-13);
    }
    EXPECT_LE((fit_of(uncrossed().groups, uncrossed().blocks, uncrossed().covariates)
                   .covariate_means()
                   .transpose() -
               uncrossed().covariates.colwise().mean())
                  .norm(),
              1e-14);
}

TEST(GroupFit, MovesAsTheFitToRowsThatCountSeveralTimes)
{
    for (const Model& model : {uncrossed(), crossed(0), crossed(1)}) {
        const GroupFit fit = fit_of(model.groups, model.blocks, model.covariates);
        const auto count = static_cast<Index>(model.groups.size());
        const MatrixXd data = test::random_matrix(count, 4, 4);
        const Grouping blocks = group_by(model.blocks);
        VectorXd times(count);
        for (Index i = 0; i < count; ++i)
            times[i] = blocks.group_of[to_size(i)] % 3;
        const GroupFit::Solution solution = fit.solve(times);
        ASSERT_TRUE(solution.is_determined);
        RowMatrix moves(count, 6);
        for (Index i = 0; i < count; ++i)
            fit.fill_moves(solution, times[i], i, moves.row(i));
        const MatrixXd moved = moves.leftCols(3).transpose() * data;
        const MatrixXd expected =
            expected_means(model, times, data) - expected_means(model, VectorXd::Ones(count), data);
        // The means of the covariates stay where they are; what all groups have in common is of no account.
        for (int group = 1; group < 3; ++group)
            EXPECT_LE(((moved.row(group) - moved.row(0)) - (expected.row(group) - expected.row(0)))
                          .norm(),
                      1e-12);
        // The means of what is left of the rows that count.
        const MatrixXd left = data - fit.expected() * (fit.references().transpose() * data);
        for (int group = 0; group < 3; ++group) {
            const std::vector<int>& rows = fit.members()[to_size(group)];
            const VectorXd own = times(rows);
            const MatrixXd of_group = left(rows, Eigen::all);
            EXPECT_LE(
                (moves.col(3 + group).transpose() * data - own.transpose() * of_group / own.sum())
                    .norm(),
                1e-12);
        }
    }
}

TEST(GroupFit, LeavesTheResidualsOfLeastSquares)
{
    const Model model = uncrossed();
    const GroupFit fit = fit_of(model.groups, model.blocks, model.covariates);
    const MatrixXd data = test::random_matrix(15, 4, 5);
    const MatrixXd hat =
        model.columns * model.columns.completeOrthogonalDecomposition().pseudoInverse();
    const MatrixXd left = data - fit.expected() * (fit.references().transpose() * data);
    EXPECT_LE((left - (data - hat * data)).cwiseAbs().maxCoeff(), 1e-12);
    EXPECT_LE((fit.leverages() - hat.diagonal()).cwiseAbs().maxCoeff(), 1e-13);
}

TEST(GroupFit, TakesMeansOfTheCovariatesOverTheRows)
{
    // Two scans of the first person, whose ages are 20 and 30.
    const MatrixXd ages = (MatrixXd(5, 1) << 20, 30, 45, 50, 70).finished();
    const GroupFit fit = fit_of({"a", "a", "a", "b", "b"}, {"1", "1", "2", "3", "4"}, ages);
    EXPECT_NEAR(fit.covariate_means()[0], (25.0 + 45.0 + 50.0 + 70.0) / 4.0, 1e-13);
    const MatrixXd rows = (MatrixXd(4, 3) << 1, 0, 25, 1, 0, 45, 0, 1, 50, 0, 1, 70).finished();
    const MatrixXd weights = rows.completeOrthogonalDecomposition().pseudoInverse().transpose() *
                             (MatrixXd(3, 2) << 1, 0, 0, 1, 47.5, 47.5).finished();
    MatrixXd expected(5, 2);
    expected << 0.5 * weights.row(0), 0.5 * weights.row(0), weights.bottomRows(3);
    EXPECT_LE((fit.means() - expected).cwiseAbs().maxCoeff(), 1e-13);
}

TEST(GroupFit, KnowsWhatTheCovariatesDoNotDetermine)
{
    const Labels groups{"a", "a", "b", "b", "c", "c"};
    const Labels each{"1", "2", "3", "4", "5", "6"};
    // The same within each group, and at the mean of all in b.
    const GroupFit between = fit_of(groups, each, (MatrixXd(6, 1) << 1, 1, 2, 2, 3, 3).finished());
    EXPECT_FALSE(between.is_determined(0));
    EXPECT_TRUE(between.is_determined(1));
    EXPECT_FALSE(between.is_determined(0, 1));
    const GroupFit alike = fit_of(groups, each, (MatrixXd(6, 1) << 1, 1, 1, 1, 3, 3).finished());
    EXPECT_FALSE(alike.is_determined(0));
    EXPECT_TRUE(alike.is_determined(0, 1));
    EXPECT_TRUE(between.means().col(0).array().isNaN().all());
    EXPECT_TRUE(between.means().col(1).allFinite());
    // Multiples of one another are one covariate.
    const VectorXd numbers = (VectorXd(6) << 1, 4, 2, 3, 9, 3).finished();
    MatrixXd twice(6, 2);
    twice << numbers, 3.0 * numbers;
    const GroupFit both = fit_of(groups, each, twice);
    EXPECT_TRUE(both.is_determined(0));
    EXPECT_LE((both.means() - fit_of(groups, each, numbers).means()).norm(), 1e-12);
    // A constant is none, and one that is the same within each block is in the effects of these.
    EXPECT_LE(
        (fit_of(groups, each, MatrixXd::Constant(6, 1, 0.1)).means() - fit_of(groups, each).means())
            .norm(),
        1e-13);
    const Labels states{"a", "b", "a", "b", "a", "b"};
    const Labels people{"1", "1", "2", "2", "3", "3"};
    const GroupFit within =
        fit_of(states, people, (MatrixXd(6, 1) << 20, 20, 30, 30, 70, 70).finished());
    EXPECT_TRUE(within.is_determined(0));
    EXPECT_LE((within.means() - fit_of(states, people).means()).norm(), 1e-13);
    // Without its only row a group has no mean, and without variation no slope.
    EXPECT_FALSE(both.solve((VectorXd(6) << 0, 0, 1, 1, 1, 1).finished()).is_determined);
    EXPECT_FALSE(both.solve((VectorXd(6) << 2, 0, 0, 2, 2, 0).finished()).is_determined);
}

TEST(GroupFit, KnowsWhichBlocksDetermineASlope)
{
    const Labels groups{"a", "b", "a", "b", "a", "b", "a", "b"};
    const Labels blocks{"1", "1", "2", "2", "3", "3", "4", "4"};
    const GroupFit one = fit_of(groups, blocks, (VectorXd(8) << 1, 1, 5, 6, 3, 3, 7, 7).finished());
    EXPECT_TRUE(one.has_slope_of_one_block());
    // About the means of groups: 3/8 of a year in one, 1/8 in the others, either way.
    const VectorXd shares{{1.0 / 12, 0.75, 1.0 / 12, 1.0 / 12}};
    EXPECT_LE((one.slope_shares() - shares).norm(), 1e-12);
    const GroupFit all = fit_of(groups, blocks, (VectorXd(8) << 1, 2, 5, 4, 3, 6, 7, 5).finished());
    EXPECT_FALSE(all.has_slope_of_one_block());
    EXPECT_FALSE(fit_of(groups, blocks).has_slope_of_one_block());
    // Without blocks leverages tell.
    EXPECT_FALSE(fit_of(groups, {"1", "2", "3", "4", "5", "6", "7", "8"},
                        (VectorXd(8) << 1, 2, 1, 2, 1, 2, 1, 2000).finished())
                     .has_slope_of_one_block());
}

TEST(GroupFit, RefusesWhatBreaksARule)
{
    const Grouping pairs = group_by({"a", "a", "b", "b"});
    EXPECT_THROW((void)GroupFit(pairs, groups_of_one(3), MatrixXd(4, 0)), InvalidInput);
    EXPECT_THROW((void)GroupFit(pairs, groups_of_one(4), MatrixXd(3, 0)), InvalidInput);
    EXPECT_THROW((void)GroupFit({{"a", "b"}, {0, 0}}, groups_of_one(2), MatrixXd(2, 0)),
                 InvalidInput);
    EXPECT_THROW((void)GroupFit(pairs, groups_of_one(4),
                                MatrixXd::Constant(4, 1, std::numeric_limits<double>::infinity())),
                 InvalidInput);
}

} // namespace
} // namespace shape::internal
