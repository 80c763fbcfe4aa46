// SPDX-License-Identifier: MIT

#include "libshape/mesh/stretched_meshes.h"

#include <gtest/gtest.h>

#include "libshape/base/random.h"
#include "libshape/base/to_size.h"
#include "tests/support/collections.h"
#include "tests/support/meshes.h"

namespace shape::internal {
namespace {

using Indices = std::vector<std::size_t>;

std::vector<Points> spheres(std::size_t count)
{
    std::vector<Points> meshes;
    for (unsigned i = 0; i < count; ++i)
        meshes.push_back(test::bumpy_sphere(2, 0.1, i).points);
    return meshes;
}

void stretch(Points& points, int axis, double factor)
{
    points.col(axis) *= factor;
}

TEST(StretchedMeshes, AreFoundWithAxisAndFactor)
{
    EXPECT_TRUE(stretched_meshes(spheres(9)).meshes.empty());
    for (const double factor : {1.7, 2.0, 0.5, 0.3})
        for (int axis = 0; axis < 3; ++axis) {
            std::vector<Points> meshes = spheres(9);
            for (const std::size_t i : {0U, 4U, 7U}) // the reference at first among them
                stretch(meshes[i], axis, factor);
            const StretchedMeshes found = stretched_meshes(meshes);
            EXPECT_EQ(found.meshes, (Indices{0, 4, 7})) << axis << ' ' << factor;
            EXPECT_EQ(found.axis, axis);
            EXPECT_NEAR(found.factor, factor, 0.1 * factor);
        }
}

TEST(StretchedMeshes, MayLieInAnyPoseAndSize)
{
    std::vector<Points> meshes = spheres(9);
    stretch(meshes[3], 2, 2.5);
    for (std::size_t i = 0; i < meshes.size(); ++i)
        meshes[i] =
            (1.0 + 0.1 * static_cast<double>(i)) * test::moved(meshes[i], static_cast<unsigned>(i));
    const StretchedMeshes found = stretched_meshes(meshes);
    EXPECT_EQ(found.meshes, Indices{3});
    EXPECT_EQ(found.axis, -1);
    EXPECT_NEAR(found.factor, 2.5, 0.25);
}

TEST(StretchedMeshes, AreNoneWhereNothingTellsWhichIsWrong)
{
    std::vector<Points> halves = spheres(8);
    for (const std::size_t i : {0U, 1U, 2U, 3U})
        stretch(halves[i], 0, 2.0);
    EXPECT_TRUE(stretched_meshes(halves).meshes.empty());
    std::vector<Points> few = spheres(4);
    stretch(few[1], 0, 2.0);
    EXPECT_TRUE(stretched_meshes(few).meshes.empty());
    std::vector<Points> both = spheres(9); // one longer, one shorter: no common cause
    stretch(both[1], 0, 2.0);
    stretch(both[2], 0, 0.5);
    EXPECT_TRUE(stretched_meshes(both).meshes.empty());
    std::vector<Points> along_two = spheres(9);
    stretch(along_two[1], 0, 2.0);
    stretch(along_two[1], 1, 1.4);
    EXPECT_TRUE(stretched_meshes(along_two).meshes.empty());
    std::vector<Points> flat = spheres(9);
    for (Points& points : flat)
        points.col(2).setZero();
    EXPECT_TRUE(stretched_meshes(flat).meshes.empty());
    // A range of stretches, as nature has, up to more than the bound.
    std::vector<Points> range = spheres(9);
    for (std::size_t i = 0; i < range.size(); ++i)
        stretch(range[i], 1, 1.0 + 0.08 * static_cast<double>(i));
    EXPECT_TRUE(stretched_meshes(range).meshes.empty());
}

TEST(StretchedMeshes, AmongRealFacesAreTheMadeOnesAlone)
{
    if (!test::has_ict_faces())
        GTEST_SKIP() << "no data";
    const Collection faces = test::ict_faces();
    Random random(11);
    for (int draw = 0; draw < 40; ++draw) {
        std::vector<Points> some;
        for (std::size_t i = 0; i < 5 + random.index(20); ++i)
            some.push_back(faces.points[random.index(faces.size())]);
        EXPECT_TRUE(stretched_meshes(some).meshes.empty()) << draw;
        const std::size_t wrong = random.index(some.size());
        stretch(some[wrong], static_cast<int>(random.index(3)), draw % 2 == 0 ? 1.8 : 0.5);
        EXPECT_EQ(stretched_meshes(some).meshes, Indices{wrong}) << draw;
    }
}

} // namespace
} // namespace shape::internal
