// SPDX-License-Identifier: MIT

#include "libshape/mesh/alignment.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "libshape/base/error.h"
#include "libshape/base/random.h"
#include "tests/support/matrices.h"
#include "tests/support/meshes.h"

namespace shape {
using namespace internal;
namespace {

double squared_distance(const Points& a, const Points& b)
{
    return (a - b).squaredNorm();
}

Eigen::Matrix3d small_turn(Random& random)
{
    const Eigen::Vector3d axis(random.normal(), random.normal(), random.normal());
    return Eigen::AngleAxisd(0.01, axis.normalized()).toRotationMatrix();
}

TEST(BestRigidMotion, UndoesAMotion)
{
    for (const test::TestMesh& mesh : test::sample_meshes())
        for (unsigned seed = 1; seed <= 20; ++seed) {
            const RigidMotion motion =
                best_rigid_motion(test::moved(mesh.points, seed), mesh.points);
            EXPECT_LE((motion(test::moved(mesh.points, seed)) - mesh.points).norm(), 1e-12)
                << mesh.name;
            EXPECT_NEAR(motion.rotation.determinant(), 1.0, 1e-14);
        }
}

TEST(BestRigidMotion, IsBetterThanEveryMotionNearIt)
{
    const Points fixed = test::bumpy_sphere(1, 0.3, 1).points;
    const Points moving = test::moved(test::bumpy_sphere(1, 0.3, 2).points, 3);
    const RigidMotion best = best_rigid_motion(moving, fixed);
    Random random(4);
    for (int i = 0; i < 100; ++i) {
        RigidMotion other = best;
        other.rotation = small_turn(random) * best.rotation;
        other.translation +=
            0.01 * Eigen::Vector3d(random.normal(), random.normal(), random.normal());
        EXPECT_GT(squared_distance(other(moving), fixed), squared_distance(best(moving), fixed));
    }
}

TEST(BestRigidMotion, NeverReflects)
{
    const Points points = test::bumpy_sphere(1, 0.3, 5).points;
    const Points mirror = points * Eigen::Vector3d(-1, 1, 1).asDiagonal();
    const RigidMotion motion = best_rigid_motion(mirror, points);
    EXPECT_NEAR(motion.rotation.determinant(), 1.0, 1e-14);
    EXPECT_GT(squared_distance(motion(mirror), points), 1e-3);
}

TEST(BestRigidMotion, TakesFlatAndSinglePoints)
{
    Points square(4, 3);
    square << 0, 0, 0, 2, 0, 0, 2, 1, 0, 0, 1, 0;
    const Points elsewhere = test::moved(square, 6);
    EXPECT_LE((best_rigid_motion(elsewhere, square)(elsewhere) - square).norm(), 1e-13);
    const Points point = square.topRows(1);
    EXPECT_LE((best_rigid_motion(elsewhere.topRows(1), point)(elsewhere.topRows(1)) - point).norm(),
              1e-14);
}

TEST(BestRigidMotion, RefusesOtherCounts)
{
    const Points points = test::tetrahedron().points;
    EXPECT_THROW((void)best_rigid_motion(points.topRows(3), points), InvalidInput);
    EXPECT_THROW((void)best_rigid_motion(Points(0, 3), Points(0, 3)), InvalidInput);
}

TEST(NearestRotation, MaximisesTheTraceOverRotations)
{
    Random random(7);
    for (unsigned seed = 1; seed <= 50; ++seed) {
        const Eigen::Matrix3d m = test::random_matrix(3, 3, seed);
        const Eigen::Matrix3d r = nearest_rotation(m);
        EXPECT_TRUE((r * r.transpose()).isIdentity(1e-14));
        EXPECT_NEAR(r.determinant(), 1.0, 1e-14);
        for (int i = 0; i < 20; ++i)
            EXPECT_GE((r.transpose() * m).trace(),
                      ((small_turn(random) * r).transpose() * m).trace());
    }
}

TEST(NearestRotation, KeepsRotations)
{
    for (unsigned seed = 1; seed <= 20; ++seed) {
        Eigen::Matrix3d rotation = test::random_orthogonal(3, seed);
        if (rotation.determinant() < 0.0)
            rotation.col(0) *= -1.0;
        EXPECT_LE((nearest_rotation(3.0 * rotation) - rotation).norm(), 1e-14);
    }
}

} // namespace
} // namespace shape
