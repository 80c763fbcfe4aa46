// SPDX-License-Identifier: MIT

#include "libshape/model/shape_distances.h"

#include <gtest/gtest.h>

#include <cmath>

#include "libshape/base/error.h"
#include "libshape/base/to_size.h"
#include "libshape/edge_space/procrustes.h"
#include "libshape/mesh/alignment.h"
#include "libshape/mesh/edge_lengths.h"
#include "tests/support/collections.h"
#include "tests/support/meshes.h"
#include "tests/support/spaces.h"

namespace shape {
using namespace internal;
namespace {

TEST(ShapeDistances, InEdgeSpaceAreThoseOfTheLengths)
{
    const Collection collection = test::bumpy_spheres(5, 1);
    const auto lengths = [&](int i) {
        return edge_lengths(collection.topology, collection.points[to_size(i)]);
    };
    const Eigen::MatrixXd plain = shape_distances(collection, {.scale = Scale::None}).matrix;
    const Eigen::MatrixXd unit = shape_distances(collection, {.scale = Scale::Unit}).matrix;
    for (int i = 0; i < 5; ++i)
        for (int j = 0; j < 5; ++j) {
            EXPECT_NEAR(plain(i, j), (lengths(i) - lengths(j)).norm(), 1e-13);
            EXPECT_NEAR(unit(i, j),
                        (lengths(i) / lengths(i).sum() - lengths(j) / lengths(j).sum()).norm(),
                        1e-15);
        }
}

TEST(ShapeDistances, OfTwoMeshesInProcrustesSpaceAreThoseOfTheBestMotion)
{
    for (unsigned seed = 1; seed <= 10; ++seed) {
        const Collection pair = test::bumpy_spheres(2, seed);
        const auto rms = [](const Points& a, const Points& b) {
            return (best_rigid_motion(b, a)(b) - a).norm() /
                   std::sqrt(static_cast<double>(a.rows()));
        };
        const double plain =
            shape_distances(pair, {.kind = SpaceKind::Procrustes, .scale = Scale::None})
                .matrix(0, 1);
        EXPECT_NEAR(plain, rms(pair.points[0], pair.points[1]), 1e-10);

        const double a = centroid_size(pair.points[0]);
        const double b = centroid_size(pair.points[1]);
        const double mean = 0.5 * (a + b);
        const double unit = shape_distances(pair, {.kind = SpaceKind::Procrustes}).matrix(0, 1);
        EXPECT_NEAR(unit, rms(mean / a * pair.points[0], mean / b * pair.points[1]), 1e-10);
    }
}

TEST(ShapeDistances, KnowNoPose)
{
    const Collection collection = test::bumpy_spheres(5, 3);
    for (const SpaceOptions& options : test::sample_spaces()) {
        const Eigen::MatrixXd here = shape_distances(collection, options).matrix;
        const Eigen::MatrixXd there = shape_distances(test::moved(collection, 60), options).matrix;
        EXPECT_LE((here - there).cwiseAbs().maxCoeff(), 1e-9 * here.maxCoeff());
    }
}

TEST(ShapeDistances, NeedTwoMeshes)
{
    EXPECT_THROW((void)shape_distances(test::bumpy_spheres(1, 1), {}), InvalidInput);
    EXPECT_THROW((void)shape_distances(test::bumpy_spheres(2, 1), {.dihedral_weight = -1.0}),
                 InvalidInput);
}

} // namespace
} // namespace shape
