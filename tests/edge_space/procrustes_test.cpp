// SPDX-License-Identifier: MIT

#include "libshape/edge_space/procrustes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "libshape/base/error.h"
#include "libshape/mesh/alignment.h"
#include "tests/support/collections.h"
#include "tests/support/meshes.h"
#include "tests/support/thread_scope.h"

namespace shape {
namespace {

Points centred(Points points, Scale scale)
{
    points.rowwise() -= Eigen::RowVector3d(points.colwise().mean());
    return scale == Scale::Unit ? Points(points / points.norm()) : points;
}

TEST(CentroidSize, OfKnownShapes)
{
    EXPECT_NEAR(centroid_size(test::tetrahedron().points), std::sqrt(12.0), 1e-15);
    const Points sphere = test::icosphere(2).points; // radius 1
    EXPECT_NEAR(centroid_size(3.0 * sphere), 3.0 * std::sqrt(162.0), 1e-12);
    EXPECT_NEAR(centroid_size(test::moved(sphere, 4)), centroid_size(sphere), 1e-12);
}

TEST(AlignedWith, UndoesAMotionAndAScale)
{
    for (const test::TestMesh& mesh : test::sample_meshes())
        for (unsigned seed = 1; seed <= 5; ++seed) {
            const Points unit = centred(mesh.points, Scale::Unit);
            EXPECT_LE((aligned_with(unit, 2.5 * test::moved(mesh.points, seed), Scale::Unit) - unit)
                          .norm(),
                      1e-13)
                << mesh.name;
            const Points plain = centred(mesh.points, Scale::None);
            EXPECT_LE(
                (aligned_with(plain, test::moved(mesh.points, seed), Scale::None) - plain).norm(),
                1e-12)
                << mesh.name;
        }
}

TEST(AlignedWith, DoesNotReflect)
{
    const Points points = centred(test::bumpy_sphere(2, 0.3, 1).points, Scale::None);
    Points mirrored = points;
    mirrored.col(0) *= -1.0;
    EXPECT_GT((aligned_with(points, mirrored, Scale::None) - points).norm(), 0.1);
}

TEST(ProcrustesMean, OfOneShapeInManyPosesIsThatShape)
{
    for (const Scale scale : {Scale::Unit, Scale::None}) {
        const Points shape = test::bumpy_sphere(2, 0.3, 7).points;
        std::vector<Points> poses;
        for (unsigned seed = 1; seed <= 6; ++seed)
            poses.push_back((scale == Scale::Unit ? seed : 1.0) * test::moved(shape, seed));
        const ProcrustesMean mean = procrustes_mean(poses, {.scale = scale});
        EXPECT_TRUE(mean.converged);
        EXPECT_LE(mean.iterations, 3);
        EXPECT_LE((mean.points - centred(poses.front(), scale)).norm(), 1e-12 * mean.points.norm());
    }
}

TEST(ProcrustesMean, OfTwoIsHalfWayAlongTheirBestMotion)
{
    for (unsigned seed = 1; seed <= 10; ++seed) {
        const Points a = test::bumpy_sphere(2, 0.3, seed).points;
        const Points b = test::moved(test::bumpy_sphere(2, 0.3, seed + 50).points, seed);
        const ProcrustesMean mean = procrustes_mean({a, b}, {.scale = Scale::None});
        const Points expected = 0.5 * (a + best_rigid_motion(b, a)(b));
        ASSERT_TRUE(mean.converged);
        // The mean stands as a up to the turn that a makes towards it: compare aligned.
        EXPECT_LE((aligned_with(centred(expected, Scale::None), mean.points, Scale::None) -
                   centred(expected, Scale::None))
                      .norm(),
                  1e-10);
    }
}

TEST(ProcrustesMean, IsTheMeanOfWhatIsAlignedWithItAndStandsAsTheFirst)
{
    for (const Scale scale : {Scale::Unit, Scale::None}) {
        const Collection collection = test::bumpy_spheres(9, 3);
        const ProcrustesMean mean = procrustes_mean(collection.points, {.scale = scale});
        ASSERT_TRUE(mean.converged);
        Points sum = Points::Zero(mean.points.rows(), 3);
        for (const Points& points : collection.points)
            sum += aligned_with(mean.points, points, scale);
        EXPECT_LE((sum / 9.0 - mean.points).norm(), 1e-11 * mean.points.norm());
        EXPECT_LE((aligned_with(mean.points, collection.points[0], scale) -
                   centred(collection.points[0], scale))
                      .norm(),
                  1e-10 * mean.points.norm());
    }
}

TEST(ProcrustesMean, DoesNotDependOnPoses)
{
    const Collection collection = test::bumpy_spheres(8, 5);
    const Collection others = test::moved(collection, 70);
    const Points here = procrustes_mean(collection.points).points;
    const Points there = procrustes_mean(others.points).points;
    EXPECT_LE((best_rigid_motion(there, here)(there) - here).norm(), 1e-11);
}

TEST(ProcrustesMean, SaysThatItDidNotConverge)
{
    const Collection collection = test::bumpy_spheres(5, 6);
    const ProcrustesMean mean = procrustes_mean(collection.points, {.max_iterations = 1});
    EXPECT_FALSE(mean.converged);
    EXPECT_EQ(mean.iterations, 1);
}

TEST(ProcrustesMean, HasTheSameBitsForAnyThreadCount)
{
    const Collection collection = test::bumpy_spheres(20, 8);
    const auto made = [&](int threads) {
        const test::ThreadScope scope(threads);
        return procrustes_mean(collection.points).points;
    };
    EXPECT_EQ(made(1), made(4));
}

TEST(ProcrustesMean, RefusesWhatBreaksARule)
{
    const Points points = test::tetrahedron().points;
    EXPECT_THROW((void)procrustes_mean({}), InvalidInput);
    EXPECT_THROW((void)procrustes_mean({points, points.topRows(3)}), InvalidInput);
    EXPECT_THROW((void)procrustes_mean({points}, {.max_iterations = 0}), InvalidInput);
    EXPECT_THROW((void)procrustes_mean({points}, {.tolerance = 0.0}), InvalidInput);
    EXPECT_THROW(
        (void)procrustes_mean({points}, {.tolerance = std::numeric_limits<double>::quiet_NaN()}),
        InvalidInput);
    EXPECT_THROW((void)procrustes_mean({Points::Ones(4, 3)}), InvalidInput);
    EXPECT_THROW((void)aligned_with(points, points.topRows(3), Scale::None), InvalidInput);
    EXPECT_THROW((void)aligned_with(points, Points::Ones(4, 3), Scale::Unit), InvalidInput);
}

} // namespace
} // namespace shape
