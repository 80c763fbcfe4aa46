// SPDX-License-Identifier: MIT

#include "libshape/statistics/regression.h"

#include <gtest/gtest.h>

#include <limits>

#include "libshape/base/error.h"
#include "libshape/statistics/inner_products.h"
#include "libshape/statistics/linear_model.h"
#include "tests/support/files.h"
#include "tests/support/matrices.h"

namespace shape {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

TEST(Regress, RecoversAPlane)
{
    const MatrixXd covariates = test::random_matrix(15, 2, 1);
    const MatrixXd slopes = test::random_matrix(2, 6, 2);
    const RowMatrix data = (covariates * slopes).rowwise() + test::random_matrix(1, 6, 3).row(0);
    const Regression result = regress(data, covariates);
    EXPECT_LE((result.slopes - slopes).cwiseAbs().maxCoeff(), 1e-13);
    EXPECT_NEAR(result.r_squared, 1.0, 1e-13);
    EXPECT_LE((result.mean - data.colwise().mean().transpose()).norm(), 1e-14);
    EXPECT_LE((result.covariate_means - covariates.colwise().mean().transpose()).norm(), 1e-14);
}

TEST(Regress, LeavesResidualsWithoutCorrelationToTheCovariates)
{
    // Covariates of very different units.
    MatrixXd covariates = test::random_matrix(40, 3, 4);
    covariates.col(1) = 1e6 * covariates.col(1).array() + 3e7;
    covariates.col(2) *= 1e-5;
    const RowMatrix data = test::random_matrix(40, 8, 5);
    const Regression result = regress(data, covariates);
    const MatrixXd centred = covariates.rowwise() - result.covariate_means.transpose();
    const MatrixXd residuals = (data - centred * result.slopes).rowwise() - result.mean.transpose();
    for (Index k = 0; k < 3; ++k)
        EXPECT_LE((centred.col(k).normalized().transpose() * residuals).cwiseAbs().maxCoeff(),
                  1e-12);
    const double total = (data.rowwise() - result.mean.transpose()).squaredNorm();
    EXPECT_NEAR(result.r_squared, 1.0 - residuals.squaredNorm() / total, 1e-12);
    EXPECT_NEAR(result.r_squared,
                test_linear_model(inner_products(data), covariates, MatrixXd(40, 0), one_group(40))
                    .r_squared,
                1e-12);
}

TEST(Regress, HasWeightsThatCarryCompanionsAlong)
{
    const MatrixXd covariates = test::random_matrix(20, 2, 6);
    const RowMatrix data = test::random_matrix(20, 5, 7);
    const RowMatrix companion = test::random_matrix(20, 3, 8);
    const Regression result = regress(data, covariates);
    EXPECT_LE(result.weights.colwise().sum().cwiseAbs().maxCoeff(), 1e-15);
    EXPECT_LE((result.weights.transpose() * companion - regress(companion, covariates).slopes)
                  .cwiseAbs()
                  .maxCoeff(),
              1e-14);
}

TEST(RegressionScores, AreTheCovariateOnTheLine)
{
    const MatrixXd covariates = 5.0 + test::random_matrix(12, 1, 9).array();
    const RowMatrix data = (covariates * test::random_matrix(1, 4, 10)).rowwise() +
                           test::random_matrix(1, 4, 11).row(0);
    const Regression result = regress(data, covariates);
    EXPECT_LE((regression_scores(result, data, 0) - covariates.col(0)).cwiseAbs().maxCoeff(),
              1e-13);
    EXPECT_THROW((void)regression_scores(result, data, 1), InvalidInput);
    EXPECT_THROW((void)regression_scores(result, data, -1), InvalidInput);
    EXPECT_THROW((void)regression_scores(result, data.leftCols(3), 0), InvalidInput);
    const Regression flat = regress(RowMatrix::Zero(12, 4), covariates);
    EXPECT_THROW((void)regression_scores(flat, RowMatrix::Zero(12, 4), 0), InvalidInput);
}

TEST(Regress, RefusesWhatBreaksARule)
{
    const RowMatrix data = test::random_matrix(6, 3, 12);
    const MatrixXd good = test::random_matrix(6, 2, 13);
    EXPECT_NO_THROW((void)regress(data, good));
    EXPECT_THROW((void)regress(data, good.topRows(5)), InvalidInput);
    EXPECT_THROW((void)regress(data, MatrixXd(6, 0)), InvalidInput);
    EXPECT_THROW((void)regress(RowMatrix(6, 0), good), InvalidInput);
    EXPECT_THROW((void)regress(data.topRows(3), good.topRows(3)), InvalidInput);
    MatrixXd bad = good;
    bad(1, 1) = std::numeric_limits<double>::quiet_NaN();
    EXPECT_THROW((void)regress(data, bad), InvalidInput);
    bad.col(1).setConstant(0.1); // constant but for rounding
    EXPECT_THROW((void)regress(data, bad), InvalidInput);
    bad.col(1) = 3.0 * bad.col(0).array() + 1.0;
    EXPECT_THROW((void)regress(data, bad), InvalidInput);
    for (const double unit : {1e300, 1e-300}) {
        bad = good;
        bad.col(1) *= unit;
        EXPECT_NE(
            test::message_of<InvalidInput>([&] { (void)regress(data, bad); }).find("overflow"),
            std::string::npos);
    }
}

} // namespace
} // namespace shape
