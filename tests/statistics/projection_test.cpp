// SPDX-License-Identifier: MIT

#include "libshape/statistics/projection.h"

#include <gtest/gtest.h>

#include <cmath>

#include "libshape/base/error.h"
#include "tests/support/matrices.h"
#include "tests/support/thread_scope.h"

namespace shape {
namespace {

TEST(ProjectOntoSubspace, SplitsAPointIntoScoresAndDistance)
{
    const Eigen::MatrixXd basis = test::random_orthogonal(20, 1);
    const Eigen::VectorXd mean = test::random_matrix(20, 1, 2);
    const RowMatrix modes = basis.leftCols(3).transpose();
    const RowMatrix scores = test::random_matrix(70, 3, 3);
    RowMatrix data = (scores * modes).rowwise() + mean.transpose();
    for (Eigen::Index i = 0; i < data.rows(); ++i)
        data.row(i) += 0.1 * static_cast<double>(i) * basis.col(5).transpose();
    const SubspaceProjection result = project_onto_subspace(data, mean, modes);
    EXPECT_LE((result.scores - scores).cwiseAbs().maxCoeff(), 1e-13);
    for (Eigen::Index i = 0; i < data.rows(); ++i)
        EXPECT_NEAR(result.residuals[i], 0.1 * static_cast<double>(i), 1e-13);
}

TEST(ProjectOntoSubspace, MeasuresDistancesFarSmallerThanTheScores)
{
    // A difference of squares would lose everything below 1e-8 of the scores.
    const Eigen::MatrixXd basis = test::random_orthogonal(20, 4);
    const RowMatrix modes = basis.leftCols(3).transpose();
    for (const double distance : {1e-6, 1e-9, 1e-12}) {
        const RowMatrix data =
            (2.0 * basis.col(0) - 5.0 * basis.col(2) + distance * basis.col(9)).transpose();
        const SubspaceProjection result =
            project_onto_subspace(data, Eigen::VectorXd::Zero(20), modes);
        EXPECT_NEAR(result.residuals[0], distance, 1e-14);
    }
}

TEST(ProjectOntoSubspace, TakesNoModesAndNoObservations)
{
    const RowMatrix data = test::random_matrix(4, 6, 5);
    const Eigen::VectorXd mean = test::random_matrix(6, 1, 6);
    const SubspaceProjection result = project_onto_subspace(data, mean, RowMatrix(0, 6));
    for (Eigen::Index i = 0; i < 4; ++i)
        EXPECT_NEAR(result.residuals[i], (data.row(i) - mean.transpose()).norm(), 1e-14);
    EXPECT_EQ(project_onto_subspace(RowMatrix(0, 6), mean, RowMatrix(0, 6)).residuals.size(), 0);
}

TEST(ProjectOntoSubspace, HasTheSameBitsForAnyThreadCount)
{
    const RowMatrix data = test::random_matrix(150, 40, 7);
    const RowMatrix modes = test::random_orthogonal(40, 8).topRows(6);
    const Eigen::VectorXd mean = test::random_matrix(40, 1, 9);
    const auto projected = [&](int threads) {
        const test::ThreadScope scope(threads);
        return project_onto_subspace(data, mean, modes);
    };
    EXPECT_EQ(projected(1).scores, projected(3).scores);
    EXPECT_EQ(projected(1).residuals, projected(3).residuals);
}

TEST(ProjectOntoSubspace, RefusesSizesThatDisagree)
{
    const RowMatrix data = test::random_matrix(4, 6, 10);
    const Eigen::VectorXd mean = Eigen::VectorXd::Zero(6);
    EXPECT_THROW((void)project_onto_subspace(data, mean.head(5), RowMatrix(1, 6)), InvalidInput);
    EXPECT_THROW((void)project_onto_subspace(data, mean, RowMatrix(1, 5)), InvalidInput);
}

} // namespace
} // namespace shape
