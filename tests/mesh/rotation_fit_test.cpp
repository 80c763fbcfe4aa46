// SPDX-License-Identifier: MIT

#include "libshape/mesh/rotation_fit.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <cmath>

#include "libshape/base/random.h"
#include "libshape/mesh/alignment.h"

namespace shape {
using namespace internal;
namespace {

Eigen::Matrix3d random_matrix(Random& random)
{
    return Eigen::Matrix3d::NullaryExpr([&] { return random.normal(); });
}

Eigen::Matrix3d random_rotation(Random& random)
{
    return Eigen::Quaterniond(random.normal(), random.normal(), random.normal(), random.normal())
        .normalized()
        .toRotationMatrix();
}

Eigen::Matrix3d turned(const Eigen::Matrix3d& rotation, double angle, Random& random)
{
    const Eigen::Vector3d axis(random.normal(), random.normal(), random.normal());
    return rotation * Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix();
}

void expect_rotation(const Eigen::Matrix3d& r)
{
    EXPECT_LT((r.transpose() * r - Eigen::Matrix3d::Identity()).norm(), 1e-14);
    EXPECT_GT(r.determinant(), 0.0);
}

/// trace(R^T m) of the nearest rotation: the singular values, the last one with the determinant's sign.
double largest_trace(const Eigen::Matrix3d& m)
{
    const Eigen::Vector3d values = Eigen::JacobiSVD<Eigen::Matrix3d>(m).singularValues();
    return values[0] + values[1] + (m.determinant() < 0.0 ? -values[2] : values[2]);
}

TEST(NearestRotation, ReachesTheTraceThatSingularValuesSay)
{
    Random random(4);
    for (int i = 0; i < 2000; ++i) {
        Eigen::Matrix3d m = random_matrix(random);
        if (i % 4 == 1) // coplanar data
            m.col(2) = m.col(0) - 2.0 * m.col(1);
        else if (i % 4 == 2) // collinear data
            m = m.col(0) * m.row(0);
        else if (i % 4 == 3) // half a turn away from the identity
            m = Eigen::Vector3d(-1.0, -1.0, 1.0).asDiagonal() *
                (m * m.transpose() + Eigen::Matrix3d::Identity());
        m *= std::pow(10.0, i % 7 - 3);
        const Eigen::Matrix3d found = nearest_rotation(m);
        expect_rotation(found);
        EXPECT_NEAR((found.transpose() * m).trace(), largest_trace(m), 1e-14 * m.norm());
    }
    expect_rotation(nearest_rotation(Eigen::Matrix3d::Zero()));
}

TEST(NearestRotation, AgreesWithTheSingularValueDecompositionFromAnyGuess)
{
    Random random(1);
    for (int i = 0; i < 2000; ++i) {
        const Eigen::Matrix3d m = random_matrix(random);
        const Eigen::Matrix3d expected = nearest_rotation(m);
        for (const double angle : {0.0, 1e-6, 0.1, 1.0, 3.1}) {
            const Eigen::Matrix3d found = nearest_rotation_from(m, turned(expected, angle, random));
            expect_rotation(found);
            EXPECT_NEAR((found.transpose() * m).trace(), largest_trace(m), 1e-13);
        }
    }
}

TEST(NearestRotation, RecoversTheRotationOfCoplanarAndThinData)
{
    Random random(2);
    for (const double thickness : {1.0, 1e-3, 1e-6})
        for (int i = 0; i < 500; ++i) {
            const Eigen::Matrix3d rotation = random_rotation(random);
            const Eigen::Matrix3d axes = random_rotation(random);
            const Eigen::Matrix3d m = rotation * axes *
                                      Eigen::Vector3d(1.0, thickness, 0.0).asDiagonal() *
                                      axes.transpose();
            const Eigen::Matrix3d found = nearest_rotation_from(m, turned(rotation, 0.5, random));
            expect_rotation(found);
            EXPECT_LT((found - rotation).norm(), 1e-14 / thickness);
        }
}

TEST(NearestRotation, StaysNearTheGuessWhereTheDataLeaveAChoice)
{
    Random random(3);
    const Eigen::Matrix3d guess = random_rotation(random);
    EXPECT_LT((nearest_rotation_from(Eigen::Matrix3d::Zero(), guess) - guess).norm(), 1.0);
    // Collinear data: the turn about their line is free.
    const Eigen::Vector3d line = Eigen::Vector3d(1.0, 2.0, -0.5).normalized();
    const Eigen::Matrix3d m = guess * line * line.transpose();
    const Eigen::Matrix3d found = nearest_rotation_from(m, guess);
    expect_rotation(found);
    EXPECT_LT((found - guess).norm(), 1e-3);
}

} // namespace
} // namespace shape
