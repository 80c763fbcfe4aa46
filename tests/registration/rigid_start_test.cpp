// SPDX-License-Identifier: MIT

#include "libshape/registration/rigid_start.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <numbers>

#include "tests/support/meshes.h"

namespace shape::test {
namespace {

using namespace internal;

/// No symmetry, and three principal axes of their own.
TestMesh lopsided()
{
    TestMesh mesh = bumpy_sphere(3, 0.3, 5);
    mesh.points.col(0) *= 1.5;
    mesh.points.col(2) *= 0.7;
    return mesh;
}

Surface surface_of(const TestMesh& mesh, const Points& points)
{
    return {points, mesh.topology.faces()};
}

double farthest(const Points& a, const Points& b)
{
    return (a - b).rowwise().norm().maxCoeff();
}

TEST(RigidStart, FindsAnyTurnFromWhereClosestPointsFindHome)
{
    const TestMesh mesh = lopsided();
    const Surface moving = surface_of(mesh, mesh.points);
    for (unsigned seed = 1; seed <= 12; ++seed) {
        const Points there = moved(mesh.points, seed);
        const std::vector<Similarity> starts = rigid_starts(moving, surface_of(mesh, there), 4);
        const double nearest =
            farthest(std::ranges::min(starts, {},
                                      [&](const Similarity& start) {
                                          return farthest(start(mesh.points), there);
                                      })(mesh.points),
                     there);
        EXPECT_LT(nearest, 0.1) << seed; // of a length of about 3
    }
}

TEST(RigidStart, BeginsWithThePlaceThatThereIsAndTurnsTheOthersByTwentyDegrees)
{
    const TestMesh mesh = lopsided();
    const std::vector<Similarity> starts =
        rigid_starts(surface_of(mesh, mesh.points), surface_of(mesh, moved(mesh.points, 3)), 6);
    ASSERT_FALSE(starts.empty());
    EXPECT_LE(starts.size(), 6U);
    EXPECT_EQ(starts[0].scale, 1.0);
    EXPECT_EQ(starts[0].motion.rotation, Eigen::Matrix3d::Identity());
    EXPECT_EQ(starts[0].motion.translation, Eigen::Vector3d::Zero());
    for (std::size_t i = 0; i < starts.size(); ++i)
        for (std::size_t k = 0; k < i; ++k) {
            const Eigen::Matrix3d turn =
                starts[i].motion.rotation.transpose() * starts[k].motion.rotation;
            EXPECT_GE(Eigen::AngleAxisd(turn).angle(), 20.0 * std::numbers::pi / 180.0);
        }
    EXPECT_EQ(rigid_starts(surface_of(mesh, mesh.points), surface_of(mesh, mesh.points), 1).size(),
              1U);
}

TEST(RigidStart, TakesSizesFarApartForUnitsAndOthersForShape)
{
    const TestMesh mesh = lopsided();
    const Surface moving = surface_of(mesh, mesh.points);
    for (const double scale : {1000.0, 2.6, 1.0 / 2.6}) {
        const Points there = scale * moved(mesh.points, 2);
        EXPECT_NEAR(landmark_start(mesh.points, there).scale, scale, 1e-12 * scale);
        EXPECT_LT(farthest(landmark_start(mesh.points, there)(mesh.points), there), 1e-11 * scale);
        EXPECT_NEAR(rigid_starts(moving, surface_of(mesh, there), 1).front().scale, scale,
                    1e-9 * scale);
    }
    for (const double scale : {2.4, 1.0 / 2.4}) {
        const Points there = scale * mesh.points;
        EXPECT_EQ(landmark_start(mesh.points, there).scale, 1.0);
        EXPECT_EQ(rigid_starts(moving, surface_of(mesh, there), 1).front().scale, 1.0);
    }
}

TEST(Similarity, IsUndoneByItsInverse)
{
    const TestMesh mesh = lopsided();
    const Similarity there = landmark_start(mesh.points, 7.0 * moved(mesh.points, 4));
    EXPECT_LT(farthest(there.inverse(there(mesh.points)), mesh.points), 1e-13);
    EXPECT_LT(farthest(there(there.inverse(mesh.points)), mesh.points), 1e-13);
}

} // namespace
} // namespace shape::test
