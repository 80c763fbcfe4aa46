// SPDX-License-Identifier: MIT

#include "libshape/mesh/congruent_meshes.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <string>

#include "libshape/mesh/collection.h"
#include "tests/support/meshes.h"

namespace shape {
using namespace internal;
namespace {

using Lists = std::vector<std::vector<std::size_t>>;
using test::TestMesh;

Points moved(const Points& points, double angle)
{
    const Eigen::Matrix3d turn =
        Eigen::AngleAxisd(angle, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
    return (points * turn.transpose()).rowwise() + Eigen::RowVector3d(1, -2, 3);
}

Points rounded_to(double spacing, const Points& points)
{
    return points.unaryExpr([&](double x) { return spacing * std::round(x / spacing); });
}

/// Further away than they are large.
Points far_away(const Points& points)
{
    return points.rowwise() + Eigen::RowVector3d(150.0, -220.0, 900.0);
}

Lists lists_of(const std::vector<Copies>& all)
{
    Lists lists;
    for (const Copies& copies : all)
        lists.push_back(copies.meshes);
    return lists;
}

/// The lists of copies among bumpy spheres.
Lists copies_among(const std::vector<Points>& points)
{
    return lists_of(congruent_meshes(test::bumpy_sphere(2, 0.1, 0).topology, points));
}

/// Seven different bumpy spheres of one size: the filter by size passes them all.
std::vector<Points> spheres()
{
    std::vector<Points> points;
    for (unsigned i = 0; i < 7; ++i)
        points.push_back(test::bumpy_sphere(2, 0.1, i).points);
    return points;
}

TEST(CongruentMeshes, AreFoundInPlaceMovedAndInSinglePrecision)
{
    std::vector<Points> points = spheres();
    EXPECT_EQ(copies_among(points), Lists{});
    points[6] = moved(points[2], 2.0);
    points[4] = points[2];
    points[5] = moved(points[1], 0.3).cast<float>().cast<double>();
    EXPECT_EQ(copies_among(points), (Lists{{1, 5}, {2, 4, 6}}));
    const std::vector<Copies> copies =
        congruent_meshes(test::bumpy_sphere(2, 0.1, 0).topology, points);
    EXPECT_EQ(copies[1].difference, 0.0);
}

TEST(CongruentMeshes, AreFoundHoweverTheirNumbersWereRounded)
{
    const Topology topology = test::bumpy_sphere(2, 0.1, 0).topology;
    const std::vector<Points> whole = spheres();
    const std::vector<Points> rounded{
        rounded_to(1e-4, whole[0]),
        rounded_to(1e-3, moved(whole[0], 0.4)),
        far_away(moved(whole[0], 2.0)).cast<float>().cast<double>(),
    };
    for (const Points& copy : rounded) {
        // Alone as well: their numbers tell.
        EXPECT_EQ(copies_among({whole[0], copy}), (Lists{{0, 1}}));
        std::vector<Points> points = whole;
        points.push_back(copy);
        const std::vector<Copies> found = congruent_meshes(topology, points);
        ASSERT_EQ(lists_of(found), (Lists{{0, 7}}));
        EXPECT_GT(found[0].difference, 1e-6);
        EXPECT_LT(found[0].difference, 1e-3);
    }
    std::vector<Points> twice = whole;
    for (const Points& points : whole)
        twice.push_back(rounded_to(1e-4, points));
    EXPECT_EQ(copies_among(twice).size(), whole.size());
}

TEST(CongruentMeshes, AreFoundWhereTheyAreFarNearerThanOthersEverAre)
{
    std::vector<Points> points = spheres();
    points[3] = points[0];
    points[3].row(9) *= 1.0 + 1e-5; // in full precision: no rounding says so
    EXPECT_EQ(copies_among(points), (Lists{{0, 3}}));
    points.resize(4);
    EXPECT_EQ(copies_among(points), Lists{}); // two others show little
    points = spheres();
    points[3] = points[0];
    points[3].row(9) *= 1.0 + 1e-3;
    EXPECT_EQ(copies_among(points), Lists{});
}

TEST(CongruentMeshes, AreNotTheNeighboursInASequence)
{
    const std::vector<Points> ends = spheres();
    for (const double step : {1e-4, 1e-3})
        for (const double spacing : {1e-12, 1e-4}) {
            std::vector<Points> frames;
            for (int k = 0; k < 100; ++k) // slowly, then faster
                frames.push_back(rounded_to(
                    spacing, ends[0] + step * k * (1.0 + 0.01 * k) * (ends[1] - ends[0])));
            frames.push_back(ends[4]);
            EXPECT_EQ(copies_among(frames), Lists{}) << step << " " << spacing;
        }
}

TEST(CongruentMeshes, AreNotMirroredScaledOrDifferentAtOneVertex)
{
    std::vector<Points> points = spheres();
    points[1] = points[0];
    points[1].col(0) *= -1.0;
    points[2] = 1.001 * points[0];
    points[3] = points[0];
    points[3].row(9) *= 1.0 + 1e-3;
    EXPECT_EQ(copies_among(points), Lists{});
}

TEST(CongruentMeshes, OneFlatMeshIsItsOwnMirrorImage)
{
    Points square(4, 3);
    square << 0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0;
    Faces faces(2, 3);
    faces << 0, 1, 2, 0, 2, 3;
    const std::vector<Points> twice{square, moved(square, 3.0)};
    EXPECT_EQ(lists_of(congruent_meshes(Topology(faces, 4), twice)), (Lists{{0, 1}}));
    EXPECT_TRUE(congruent_meshes(Topology(faces, 4), {}).empty());
}

TEST(CongruentMeshes, OfAStreamThoseAreComparedThatMayBeCopies)
{
    Collection stream{test::bumpy_sphere(2, 0.1, 0).topology, {}, {}, {}};
    for (unsigned i = 0; i < 100; ++i) {
        stream.names.push_back(std::to_string(i));
        stream.points.push_back(test::bumpy_sphere(2, 0.1, i).points);
    }
    const std::vector<Points> added{test::bumpy_sphere(2, 0.1, 200).points,
                                    rounded_to(1e-4, moved(stream.points[77], 1.0))};
    const std::vector<std::size_t> chosen = meshes_to_compare(stream_of(stream), added);
    EXPECT_EQ(chosen, (std::vector<std::size_t>{0, 12, 25, 37, 50, 62, 75, 77, 87}));
    // Of a sequence as many as show that it is one.
    for (std::size_t i = 0; i < 90; ++i)
        stream.points[i] = (1.0 + 1e-7 * static_cast<double>(i)) * added[0];
    EXPECT_EQ(meshes_to_compare(stream_of(stream), added).size(), 33U + 5U);
}

} // namespace
} // namespace shape
