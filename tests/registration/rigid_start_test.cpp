// SPDX-License-Identifier: MIT

#include "libshape/registration/rigid_start.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

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

TEST(RigidStart, BeginsWithTheAxesThatThereAreAndEndsWithThePlace)
{
    const TestMesh mesh = lopsided();
    const Surface moving = surface_of(mesh, mesh.points);
    const Surface there = surface_of(mesh, 1.04 * moved(mesh.points, 3));
    const std::vector<Similarity> starts = rigid_starts(moving, there, 6);
    ASSERT_GE(starts.size(), 2U);
    EXPECT_LE(starts.size(), 7U);
    EXPECT_EQ(starts.front().motion.rotation, Eigen::Matrix3d::Identity());
    EXPECT_EQ(starts.back().scale, 1.0);
    EXPECT_EQ(starts.back().motion.rotation, Eigen::Matrix3d::Identity());
    EXPECT_EQ(starts.back().motion.translation, Eigen::Vector3d::Zero());
    for (std::size_t i = 0; i + 1 < starts.size(); ++i) {
        EXPECT_NEAR(starts[i].scale, 1.04, 1e-9);
        for (std::size_t k = 0; k < i; ++k)
            EXPECT_GE(turn_angle(starts[i].motion.rotation.transpose() * starts[k].motion.rotation),
                      same_way);
    }
    EXPECT_EQ(rigid_starts(moving, there, 1).size(), 2U);
}

TEST(RigidStart, FindsWhatIsFarAwayButNotTurned)
{
    const TestMesh mesh = lopsided();
    const Points there = mesh.points.rowwise() + Eigen::RowVector3d(20.0, -3.0, 5.0);
    const std::vector<Similarity> starts =
        rigid_starts(surface_of(mesh, mesh.points), surface_of(mesh, there), 4);
    EXPECT_LT(farthest(starts.front()(mesh.points), there), 1e-9);
}

TEST(RigidStart, AreThoseOfALargerScanButForTheFactor)
{
    const TestMesh mesh = lopsided();
    const Surface moving = surface_of(mesh, mesh.points);
    const Points there = 1.2 * moved(mesh.points, 2);
    const auto at_size = [&](double factor) {
        std::vector<Similarity> starts = rigid_starts(moving, surface_of(mesh, factor * there), 4);
        std::erase_if(starts, [](const Similarity& start) {
            return std::abs(start.scale / change_of_unit(start.scale) - 1.0) < 1e-9;
        });
        return starts;
    };
    const std::vector<Similarity> known = at_size(1.0);
    ASSERT_EQ(known.size(), 4U);
    for (const double factor : {1000.0, 0.001, 7.0}) {
        const std::vector<Similarity> starts = at_size(factor);
        ASSERT_EQ(starts.size(), known.size()) << factor;
        for (std::size_t i = 0; i < starts.size(); ++i)
            EXPECT_LT(farthest(starts[i](mesh.points), factor * known[i](mesh.points)),
                      1e-6 * factor)
                << factor << ", " << i;
    }
    // Where the size leaves the unit open, there are as many at the unit.
    const std::vector<Similarity> all = rigid_starts(moving, surface_of(mesh, there), 4);
    EXPECT_EQ(std::ranges::count(all, 1.0, &Similarity::scale), 4);
}

TEST(RigidStart, LandmarksSayHowLargeAScanIs)
{
    const TestMesh mesh = lopsided();
    for (const double scale : {1000.0, 2.6, 1.3, 1.0 / 2.6}) {
        const Points there = scale * moved(mesh.points, 2);
        EXPECT_NEAR(landmark_start(mesh.points, there).scale, scale, 1e-12 * scale);
        EXPECT_LT(farthest(landmark_start(mesh.points, there)(mesh.points), there), 1e-11 * scale);
    }
}

TEST(RigidStart, TakesSizesFarApartForUnitsAndOthersForShape)
{
    for (const double ratio : {2.4, 1.05, 1.0, 1.0 / 2.4})
        EXPECT_EQ(change_of_unit(ratio), 1.0) << ratio;
    EXPECT_EQ(change_of_unit(1250.0), 1000.0);
    EXPECT_EQ(change_of_unit(750.0), 1000.0);
    EXPECT_EQ(change_of_unit(0.0011), 0.001);
    EXPECT_EQ(change_of_unit(24.0), 25.4);
    EXPECT_EQ(change_of_unit(2.6), 2.54);
    EXPECT_EQ(change_of_unit(7e5), 7e5);
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
