// SPDX-License-Identifier: MIT

#include "libshape/mesh/congruent_meshes.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

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
    const Topology topology = test::bumpy_sphere(2, 0.1, 0).topology;
    std::vector<Points> points = spheres();
    EXPECT_EQ(congruent_meshes(topology, points), Lists{});
    points[6] = moved(points[2], 2.0);
    points[4] = points[2];
    points[5] = moved(points[1], 0.3).cast<float>().cast<double>();
    EXPECT_EQ(congruent_meshes(topology, points), (Lists{{1, 5}, {2, 4, 6}}));
}

TEST(CongruentMeshes, AreNotMirroredScaledOrDifferentAtOneVertex)
{
    const Topology topology = test::bumpy_sphere(2, 0.1, 0).topology;
    std::vector<Points> points = spheres();
    points[1] = points[0];
    points[1].col(0) *= -1.0;
    points[2] = 1.001 * points[0];
    points[3] = points[0];
    points[3].row(9) *= 1.0 + 1e-4;
    EXPECT_EQ(congruent_meshes(topology, points), Lists{});
}

TEST(CongruentMeshes, OneFlatMeshIsItsOwnMirrorImage)
{
    Points square(4, 3);
    square << 0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0;
    Faces faces(2, 3);
    faces << 0, 1, 2, 0, 2, 3;
    const std::vector<Points> twice{square, moved(square, 3.0)};
    EXPECT_EQ(congruent_meshes(Topology(faces, 4), twice), (Lists{{0, 1}}));
    EXPECT_EQ(congruent_meshes(Topology(faces, 4), {}), Lists{});
}

} // namespace
} // namespace shape
