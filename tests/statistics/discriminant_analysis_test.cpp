// SPDX-License-Identifier: MIT

#include "libshape/statistics/discriminant_analysis.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <limits>

#include "libshape/base/error.h"
#include "libshape/base/to_size.h"
#include "tests/support/matrices.h"

namespace shape {
using namespace internal;
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

/// Points of four correlated coordinates in three groups of 10, 20 and 30.
struct Sample
{
    RowMatrix points;
    Grouping groups;
};

Sample sample(unsigned seed)
{
    Sample result{test::random_matrix(60, 4, seed) * test::random_matrix(4, 4, seed + 1), {}};
    const MatrixXd means = 2.0 * test::random_matrix(3, 4, seed + 2);
    result.groups.names = {"a", "b", "c"};
    for (Index i = 0; i < 60; ++i) {
        const int group = i < 10 ? 0 : i < 30 ? 1 : 2;
        result.groups.group_of.push_back(group);
        result.points.row(i) += means.row(group);
    }
    return result;
}

MatrixXd group_means(const Sample& s)
{
    const MatrixXd indicator = indicators(s.groups);
    return indicator.colwise().sum().cwiseInverse().asDiagonal() *
           (indicator.transpose() * s.points);
}

/// The pooled covariance within the groups.
MatrixXd pooled_covariance(const Sample& s)
{
    const MatrixXd within = s.points - indicators(s.groups) * group_means(s);
    return within.transpose() * within / static_cast<double>(60 - 3);
}

TEST(DiscriminantAnalysis, HasAxesOfUnitCovarianceWithinTheGroups)
{
    const Sample s = sample(1);
    const DiscriminantAnalysis result = discriminant_analysis(s.points, s.groups);
    ASSERT_EQ(result.axes.rows(), 2);
    EXPECT_TRUE((result.axes * pooled_covariance(s) * result.axes.transpose()).isIdentity(1e-12));
    const MatrixXd expected =
        (group_means(s).rowwise() - s.points.colwise().mean()) * result.axes.transpose();
    EXPECT_LE((result.group_means - expected).cwiseAbs().maxCoeff(), 1e-12);
    EXPECT_NEAR(std::exp(result.log_priors[1]), 20.0 / 60.0, 1e-15);
}

TEST(DiscriminantAnalysis, SolvesTheEigenproblemOfBetweenAndWithin)
{
    const Sample s = sample(2);
    const DiscriminantAnalysis result = discriminant_analysis(s.points, s.groups);
    const MatrixXd means = group_means(s).rowwise() - s.points.colwise().mean();
    const MatrixXd between =
        means.transpose() * Eigen::Vector3d(10.0, 20.0, 30.0).asDiagonal() * means / 2.0;
    const MatrixXd within = pooled_covariance(s);
    for (Index k = 0; k < 2; ++k) {
        const Eigen::VectorXd axis = result.axes.row(k).transpose();
        EXPECT_LE((between * axis - result.ratios[k] * within * axis).norm(),
                  1e-11 * (between * axis).norm());
    }
    EXPECT_GE(result.ratios[0], result.ratios[1]);
}

TEST(DiscriminantAnalysis, OfTwoGroupsIsTheDirectionOfFisher)
{
    Sample s = sample(3);
    for (int& group : s.groups.group_of)
        group = std::min(group, 1);
    s.groups.names.pop_back();
    const DiscriminantAnalysis result = discriminant_analysis(s.points, s.groups);
    const MatrixXd means = group_means(s);
    Eigen::VectorXd fisher =
        pooled_covariance(s).inverse() * (means.row(1) - means.row(0)).transpose();
    const double cosine = result.axes.row(0).dot(fisher) / (result.axes.norm() * fisher.norm());
    EXPECT_NEAR(std::abs(cosine), 1.0, 1e-12);
}

TEST(Classify, PrefersTheLeastMahalanobisDistanceLessTheLogOfThePrior)
{
    const Sample s = sample(4);
    const DiscriminantAnalysis analysis = discriminant_analysis(s.points, s.groups);
    const MatrixXd inverse = pooled_covariance(s).inverse();
    const MatrixXd means = group_means(s);
    const RowMatrix points = 3.0 * test::random_matrix(200, 4, 40);
    const std::vector<int> groups = classify(analysis, points);
    const double sizes[] = {10.0, 20.0, 30.0};
    std::vector<int> found(3, 0);
    for (Index i = 0; i < 200; ++i) {
        int best = -1;
        double least = std::numeric_limits<double>::infinity();
        for (int g = 0; g < 3; ++g) {
            const Eigen::VectorXd gap = (points.row(i) - means.row(g)).transpose();
            const double cost = 0.5 * gap.dot(inverse * gap) - std::log(sizes[g]);
            if (cost < least) {
                least = cost;
                best = g;
            }
        }
        EXPECT_EQ(groups[to_size(i)], best);
        ++found[to_size(best)];
    }
    EXPECT_GT(*std::min_element(found.begin(), found.end()), 5); // all three occur
}

TEST(DiscriminantAnalysis, DoesNotKnowTheCoordinates)
{
    const Sample s = sample(5);
    const DiscriminantAnalysis one = discriminant_analysis(s.points, s.groups);
    const RowMatrix other =
        (s.points * test::random_matrix(4, 4, 50)).rowwise() + test::random_matrix(1, 4, 51).row(0);
    const DiscriminantAnalysis two = discriminant_analysis(other, s.groups);
    EXPECT_LE((one.ratios - two.ratios).norm(), 1e-10 * one.ratios.norm());
    EXPECT_LE(
        (canonical_variates(one, s.points).cwiseAbs() - canonical_variates(two, other).cwiseAbs())
            .cwiseAbs()
            .maxCoeff(),
        1e-9);
    EXPECT_EQ(classify(one, s.points), classify(two, other));
}

TEST(DiscriminantAnalysis, RefusesWhatBreaksARule)
{
    const Sample s = sample(6);
    EXPECT_THROW((void)discriminant_analysis(s.points.topRows(50), s.groups), InvalidInput);
    EXPECT_THROW((void)discriminant_analysis(RowMatrix(60, 0), s.groups), InvalidInput);
    EXPECT_THROW((void)discriminant_analysis(s.points, one_group(60)), InvalidInput);
    EXPECT_THROW((void)discriminant_analysis(test::random_matrix(6, 4, 60),
                                             group_by({"a", "b", "c", "a", "b", "c"})),
                 InvalidInput);
    RowMatrix infinite = s.points;
    infinite(3, 2) = std::numeric_limits<double>::infinity();
    EXPECT_THROW((void)discriminant_analysis(infinite, s.groups), InvalidInput);
    RowMatrix singular = s.points;
    singular.col(3) = singular.col(0) - 2.0 * singular.col(1);
    EXPECT_THROW((void)discriminant_analysis(singular, s.groups), NumericalError);
    singular.col(3).setZero();
    EXPECT_THROW((void)discriminant_analysis(singular, s.groups), NumericalError);
    const DiscriminantAnalysis analysis = discriminant_analysis(s.points, s.groups);
    EXPECT_THROW((void)canonical_variates(analysis, s.points.leftCols(3)), InvalidInput);
    EXPECT_THROW((void)classify(analysis, s.points.leftCols(3)), InvalidInput);
}

} // namespace
} // namespace shape
