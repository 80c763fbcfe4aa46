// SPDX-License-Identifier: MIT

#include "libshape/registration/closest_points.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <random>

#include "libshape/base/error.h"
#include "libshape/mesh/nearest_in_triangle.h"
#include "tests/support/meshes.h"

namespace shape::test {
using namespace internal;
namespace {

using Eigen::Vector3d;

/// All faces, one after the other, by sampling the triangle densely and then the exact formula.
double brute_force(const Points& points, const Faces& faces, const Vector3d& p)
{
    double least = 1e300;
    for (const auto& face : faces.rowwise()) {
        const Vector3d a = points.row(face[0]), b = points.row(face[1]), c = points.row(face[2]);
        const Vector3d w = nearest_in_triangle(p, a, b, c);
        least = std::min(least, (w[0] * a + w[1] * b + w[2] * c - p).norm());
    }
    return least;
}

TEST(NearestInTriangle, IsNoFartherThanAnyOtherPointOfIt)
{
    std::mt19937 random(1);
    std::uniform_real_distribution<double> number(-1.0, 1.0);
    const auto point = [&] { return Vector3d(number(random), number(random), number(random)); };
    for (int trial = 0; trial < 200; ++trial) {
        const Vector3d a = point(), b = point(),
                       c = trial % 4 == 0 ? Vector3d(0.5 * (a + b)) : point();
        const Vector3d p = 2.0 * point();
        const Vector3d w = nearest_in_triangle(p, a, b, c);
        EXPECT_NEAR(w.sum(), 1.0, 1e-12);
        EXPECT_GE(w.minCoeff(), 0.0);
        const double found = (w[0] * a + w[1] * b + w[2] * c - p).norm();
        for (int i = 0; i <= 20; ++i)
            for (int j = 0; j + i <= 20; ++j) {
                const Vector3d other = a + i / 20.0 * (b - a) + j / 20.0 * (c - a);
                EXPECT_LE(found, (other - p).norm() + 1e-12);
            }
    }
}

TEST(ClosestPoints, FindWhatTryingAllFacesFinds)
{
    TestMesh mesh = bumpy_sphere(3, 0.3, 7);
    mesh.points.col(0) *= 20.0; // faces of very different sizes
    const ClosestPoints tree(mesh.points, mesh.topology.faces());
    std::mt19937 random(2);
    std::normal_distribution<double> number(0.0, 3.0);
    for (int trial = 0; trial < 300; ++trial) {
        const Vector3d p(5.0 * number(random), number(random), number(random));
        const SurfacePoint found = tree.nearest(p);
        EXPECT_NEAR(found.distance, brute_force(mesh.points, mesh.topology.faces(), p), 1e-12);
        EXPECT_NEAR((found.position - p).norm(), found.distance, 1e-12);
    }
}

TEST(ClosestPoints, AreTheSameWhateverTheGuess)
{
    const TestMesh mesh = bumpy_sphere(3, 0.3, 7);
    const ClosestPoints tree(mesh.points, mesh.topology.faces());
    std::mt19937 random(3);
    std::normal_distribution<double> number(0.0, 1.0);
    std::uniform_int_distribution<int> face(0, mesh.topology.face_count() - 1);
    for (int trial = 0; trial < 300; ++trial) {
        // Of a vertex, several faces are the nearest.
        const Vector3d p = trial % 2 == 0 ? Vector3d(number(random), number(random), number(random))
                                          : Vector3d(mesh.points.row(trial));
        NearestRule rule;
        rule.within = 1.0;
        rule.normal = Vector3d(number(random), number(random), number(random)).normalized();
        rule.least_cosine = 0.3;
        const SurfacePoint found = tree.nearest(p, rule);
        rule.guess = face(random);
        const SurfacePoint guessed = tree.nearest(p, rule);
        EXPECT_EQ(guessed.face, found.face);
        EXPECT_EQ(guessed.position, found.position);
    }
}

TEST(ClosestPoints, ANearPointIsHardlyFartherThanTheNearest)
{
    TestMesh mesh = bumpy_sphere(3, 0.3, 7);
    mesh.points.col(0) *= 20.0;
    const ClosestPoints tree(mesh.points, mesh.topology.faces());
    std::mt19937 random(4);
    std::normal_distribution<double> number(0.0, 3.0);
    for (int trial = 0; trial < 300; ++trial) {
        const Vector3d p(5.0 * number(random), number(random), number(random));
        const Vector3d near = tree.near_point(p);
        EXPECT_LE((near - p).norm(), tree.nearest(p).distance + tree.cover() + 1e-12);
        EXPECT_NEAR(tree.nearest(near).distance, 0.0, 1e-12);
    }
}

TEST(ClosestPoints, KeepToFacesWhoseNormalsAgreeAndToTheDistance)
{
    const TestMesh mesh = icosphere(2);
    const ClosestPoints tree(mesh.points, mesh.topology.faces());
    NearestRule rule;
    rule.normal = Vector3d::UnitX();
    rule.least_cosine = 0.5;
    const SurfacePoint far = tree.nearest({-2.0, 0.0, 0.0}, rule);
    ASSERT_GE(far.face, 0);
    EXPECT_GT(far.position[0], 0.3); // the near side faces away
    rule.within = 1.5;
    EXPECT_EQ(tree.nearest({-2.0, 0.0, 0.0}, rule).face, -1);
}

TEST(ClosestPoints, RefuseWhatIsNotATriangle)
{
    EXPECT_THROW(ClosestPoints(Points::Zero(3, 3), Faces(0, 3)), InvalidInput);
    Faces outside(1, 3);
    outside << 0, 1, 3;
    EXPECT_THROW(ClosestPoints(Points::Zero(3, 3), outside), InvalidInput);
    Faces good(1, 3);
    good << 0, 1, 2;
    Points nan = Points::Zero(3, 3);
    nan(0, 0) = std::numeric_limits<double>::quiet_NaN();
    EXPECT_THROW(ClosestPoints(nan, good), InvalidInput);
}

} // namespace
} // namespace shape::test
