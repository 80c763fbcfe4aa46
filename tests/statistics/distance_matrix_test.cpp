// SPDX-License-Identifier: MIT

#include "libshape/statistics/distance_matrix.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "libshape/base/error.h"
#include "tests/support/matrices.h"
#include "tests/support/thread_scope.h"

namespace shape {
namespace {

TEST(DistanceMatrix, OfKnownPoints)
{
    RowMatrix points(3, 2);
    points << 0, 0, 3, 4, 3, 0;
    Eigen::Matrix3d expected;
    expected << 0, 5, 3, 5, 0, 4, 3, 4, 0;
    EXPECT_EQ(distance_matrix(points), expected);
}

TEST(DistanceMatrix, IsAMetricThatMotionsKeep)
{
    for (unsigned seed = 1; seed <= 10; ++seed) {
        const RowMatrix points = test::random_matrix(12, 5, seed);
        const Eigen::MatrixXd d = distance_matrix(points);
        EXPECT_NO_THROW(check_distances(d));
        for (int i = 0; i < 12; ++i)
            for (int j = 0; j < 12; ++j)
                for (int k = 0; k < 12; ++k)
                    EXPECT_LE(d(i, k), d(i, j) + d(j, k) + 1e-14);
        const RowMatrix turned = (points * test::random_orthogonal(5, seed + 20)).rowwise() +
                                 Eigen::RowVectorXd(test::random_matrix(1, 5, seed + 40));
        EXPECT_LE((distance_matrix(turned) - d).cwiseAbs().maxCoeff(), 1e-13);
    }
}

TEST(DistanceMatrix, KeepsTheDigitsOfSmallDistances)
{
    RowMatrix points = RowMatrix::Constant(2, 1000, 1.0);
    points(1, 7) += 1e-12;
    EXPECT_EQ(distance_matrix(points)(0, 1), points(1, 7) - points(0, 7));
}

TEST(DistanceMatrix, HasTheSameBitsForAnyThreadCount)
{
    const RowMatrix points = test::random_matrix(70, 40, 3);
    const auto made = [&](int threads) {
        const test::ThreadScope scope(threads);
        return distance_matrix(points);
    };
    EXPECT_EQ(made(1), made(4));
}

TEST(DistanceMatrix, RefusesWhatIsNotFinite)
{
    RowMatrix points = RowMatrix::Zero(2, 2);
    points(1, 1) = std::numeric_limits<double>::infinity();
    EXPECT_THROW((void)distance_matrix(points), InvalidInput);
}

TEST(CheckDistances, RefusesWhatBreaksARule)
{
    const Eigen::MatrixXd good = distance_matrix(test::random_matrix(4, 2, 1));
    const auto refused = [&](int row, int column, double value) {
        Eigen::MatrixXd bad = good;
        bad(row, column) = value;
        EXPECT_THROW(check_distances(bad), InvalidInput);
    };
    refused(1, 1, 1.0);
    refused(1, 2, good(1, 2) * 1.1);
    refused(1, 2, std::numeric_limits<double>::quiet_NaN());
    EXPECT_THROW(check_distances(-good), InvalidInput);
    EXPECT_THROW(check_distances(good.topRows(3)), InvalidInput);
    EXPECT_THROW(check_distances(Eigen::MatrixXd()), InvalidInput);
}

} // namespace
} // namespace shape
