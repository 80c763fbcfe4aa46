// SPDX-License-Identifier: MIT

#include "libshape/statistics/classical_scaling.h"

#include <gtest/gtest.h>

#include <cmath>

#include "libshape/base/error.h"
#include "libshape/statistics/distance_matrix.h"
#include "libshape/statistics/principal_components.h"
#include "tests/support/matrices.h"

namespace shape {
namespace {

TEST(ClassicalScaling, GivesDistancesInTheSameDimensionBack)
{
    for (const int dimensions : {1, 2, 3})
        for (unsigned seed = 1; seed <= 10; ++seed) {
            const Eigen::MatrixXd distances =
                distance_matrix(test::random_matrix(15, dimensions, seed));
            const ClassicalScaling scaling = classical_scaling(distances, dimensions);
            EXPECT_LE((distance_matrix(scaling.points) - distances).cwiseAbs().maxCoeff(), 1e-12);
            EXPECT_NEAR(scaling.eigenvalues.sum(), scaling.total, 1e-12 * scaling.total);
        }
}

TEST(ClassicalScaling, OfASquareAndOfTheCornersOfATriangle)
{
    RowMatrix square(4, 2);
    square << 0, 0, 2, 0, 2, 2, 0, 2;
    const ClassicalScaling scaling = classical_scaling(distance_matrix(square), 3);
    EXPECT_NEAR(scaling.eigenvalues[0], 4.0, 1e-13);
    EXPECT_NEAR(scaling.eigenvalues[1], 4.0, 1e-13);
    EXPECT_NEAR(scaling.eigenvalues[2], 0.0, 1e-13);
    // Three things at distance 1 from each other: sum of squares 3 * 1/3.
    const ClassicalScaling corners =
        classical_scaling(Eigen::Matrix3d::Ones() - Eigen::Matrix3d::Identity(), 2);
    EXPECT_NEAR(corners.total, 1.0, 1e-14);
    for (int i = 0; i < 3; ++i)
        EXPECT_NEAR(corners.points.row(i).norm(), 1.0 / std::sqrt(3.0), 1e-14);
}

TEST(ClassicalScaling, OfMoreDimensionsIsThePrincipalComponents)
{
    for (unsigned seed = 1; seed <= 5; ++seed) {
        const RowMatrix data = test::random_matrix(12, 30, seed);
        const PrincipalComponents components = principal_components(data, {.modes = 2});
        const ClassicalScaling scaling = classical_scaling(distance_matrix(data), 2);
        for (int k = 0; k < 2; ++k) {
            const double sign = scaling.points.col(k).dot(components.scores.col(k)) < 0 ? -1 : 1;
            EXPECT_LE((sign * scaling.points.col(k) - components.scores.col(k)).norm(), 1e-10);
            EXPECT_NEAR(scaling.eigenvalues[k] / 11.0, components.variances[k], 1e-11);
        }
        EXPECT_NEAR(scaling.total / 11.0, components.total_variance, 1e-11);
    }
}

TEST(ClassicalScaling, MakesTheLargestEntryPositive)
{
    for (unsigned seed = 1; seed <= 20; ++seed) {
        const ClassicalScaling scaling =
            classical_scaling(distance_matrix(test::random_matrix(9, 4, seed)), 3);
        for (int k = 0; k < 3; ++k)
            EXPECT_GT(scaling.points.col(k).maxCoeff(), -scaling.points.col(k).minCoeff());
    }
    // Two points: both entries are as large, the first counts.
    EXPECT_NEAR(classical_scaling(distance_matrix(Eigen::Vector2d(0, 3)), 1).points(0, 0), 1.5,
                1e-14);
}

TEST(ClassicalScaling, LeavesOutWhatNoPointsCanHave)
{
    // Violates the triangle inequality: one eigenvalue is negative.
    Eigen::Matrix3d distances;
    distances << 0, 1, 3, 1, 0, 1, 3, 1, 0;
    const ClassicalScaling scaling = classical_scaling(distances, 3);
    EXPECT_LT(scaling.eigenvalues[2], -0.1);
    EXPECT_EQ(scaling.points.col(2), Eigen::Vector3d::Zero());
    EXPECT_GT(scaling.eigenvalues.head(2).sum(), scaling.total);
}

TEST(ClassicalScaling, OfThingsThatAreAllEqualIsOnePoint)
{
    const ClassicalScaling scaling = classical_scaling(Eigen::MatrixXd::Zero(4, 4), 2);
    EXPECT_LE(scaling.points.norm(), 1e-15);
}

TEST(ClassicalScaling, RefusesWhatBreaksARule)
{
    const Eigen::MatrixXd distances = distance_matrix(test::random_matrix(4, 2, 1));
    EXPECT_THROW((void)classical_scaling(distances, 0), InvalidInput);
    EXPECT_THROW((void)classical_scaling(distances, 5), InvalidInput);
    EXPECT_THROW((void)classical_scaling(-distances, 1), InvalidInput);
}

} // namespace
} // namespace shape
