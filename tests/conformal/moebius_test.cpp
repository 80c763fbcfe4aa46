// SPDX-License-Identifier: MIT

#include "libshape/conformal/moebius.h"

#include <gtest/gtest.h>

#include <cmath>

#include "libshape/base/random.h"

namespace shape {
using namespace internal;
namespace {

using Complex = std::complex<double>;

/// Points of the plane in two clusters of very different size, the last one at infinity.
struct Cloud
{
    Eigen::VectorXcd positions;
    Eigen::VectorXd weights;
    int infinite = 0;
};

Cloud random_cloud(int count, unsigned seed)
{
    Random random(seed);
    Cloud cloud{Eigen::VectorXcd(count), Eigen::VectorXd(count), count - 1};
    const Complex centre(random.normal(), random.normal());
    const double size = std::pow(10.0, random.uniform(-4.0, 3.0));
    for (int v = 0; v < count; ++v) {
        const double spread = v % 5 == 0 ? 1e-3 * size : size;
        cloud.positions[v] = centre + spread * Complex(random.normal(), random.normal());
        cloud.weights[v] = random.uniform(0.1, 1.0);
    }
    return cloud;
}

PlanarLayout layout_of(const Cloud& cloud)
{
    return {cloud.positions, Eigen::VectorXcd::Zero(cloud.positions.size())};
}

TEST(BalanceOnSphere, BringsTheMeanToTheCentreInAFewNewtonSteps)
{
    for (unsigned seed = 1; seed <= 100; ++seed) {
        const Cloud cloud = random_cloud(50, seed);
        const MoebiusBalance balance =
            balance_on_sphere(cloud.positions, cloud.weights, cloud.infinite);
        EXPECT_LE(balance.residual, 1e-12);
        EXPECT_LE(balance.iterations, 15);
        const SpherePoints sphere =
            project_to_sphere(layout_of(cloud), balance.frame, cloud.infinite);
        const Eigen::RowVector3d mean =
            cloud.weights.transpose() * sphere.points / cloud.weights.sum();
        EXPECT_LE(mean.norm(), 1e-12);
    }
}

TEST(BalanceOnSphere, IsUniqueUpToRotationsWhateverTheStart)
{
    for (unsigned seed = 1; seed <= 20; ++seed) {
        const Cloud cloud = random_cloud(30, seed);
        // The same points after an inversion of the plane, with another one at infinity.
        Cloud other = cloud;
        other.infinite = 0;
        for (int v = 0; v < cloud.positions.size(); ++v)
            other.positions[v] =
                v == cloud.infinite
                    ? Complex(0.0)
                    : std::conj(1.0 / std::conj(cloud.positions[v] - cloud.positions[0]));
        const auto project = [](const Cloud& c) {
            const MoebiusBalance balance = balance_on_sphere(c.positions, c.weights, c.infinite);
            return project_to_sphere(layout_of(c), balance.frame, c.infinite);
        };
        const SpherePoints a = project(cloud);
        const SpherePoints b = project(other);
        for (int v = 0; v < cloud.positions.size(); ++v)
            for (int w = 0; w < v; ++w)
                EXPECT_NEAR(a.difference(v, w).norm(), b.difference(v, w).norm(), 1e-10);
    }
}

TEST(ProjectToSphere, IsStereographic)
{
    PlanarLayout layout{Eigen::VectorXcd(4), Eigen::VectorXcd::Zero(4)};
    layout.positions << Complex(0, 0), Complex(1, 0), Complex(0, 1), Complex(7, 7);
    const SpherePoints sphere = project_to_sphere(layout, {}, 3);
    Points expected(4, 3);
    expected << 0, 0, 1, 1, 0, 0, 0, 1, 0, 0, 0, -1;
    EXPECT_EQ((sphere.points - expected).norm(), 0.0);
}

TEST(ProjectToSphere, KeepsDifferencesThatDoublesCannotHold)
{
    // Two points 1e-20 apart: the chord is 2 |dz| / (1 + |z|^2).
    PlanarLayout layout{Eigen::VectorXcd(3), Eigen::VectorXcd::Zero(3)};
    layout.positions << Complex(0.7, -0.3), Complex(0.7, -0.3), Complex(0, 0);
    layout.remainders[1] = Complex(3e-20, 4e-20);
    const SpherePoints sphere = project_to_sphere(layout, {}, 2);
    EXPECT_EQ(sphere.points.row(0), sphere.points.row(1));
    EXPECT_NEAR(sphere.difference(0, 1).norm() / (2.0 * 5e-20 / 1.58), 1.0, 1e-11);
}

} // namespace
} // namespace shape
