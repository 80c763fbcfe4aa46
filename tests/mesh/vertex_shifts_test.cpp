// SPDX-License-Identifier: MIT

#include "libshape/mesh/vertex_shifts.h"

#include <gtest/gtest.h>

#include <numeric>

#include "tests/support/meshes.h"

namespace shape {
using namespace internal;
namespace {

TEST(VertexShifts, AreNoneOfAffineImages)
{
    test::TestMesh flat = test::open_patch(8, 1);
    flat.points.col(2).setZero();
    std::vector<Points> meshes(3, flat.points);
    meshes[1] =
        flat.points * (Eigen::Matrix3d() << 2.0, 0.3, 0.5, 0.0, 1.0, 0.2, 0.0, 0.0, 1.0).finished();
    for (const int rings : {1, 2}) {
        const VertexShifts found = vertex_shifts(flat.topology, meshes, rings, 1000);
        EXPECT_GE(found.vertices.size(), 79U); // all but two corners with two neighbours
        EXPECT_EQ(found.shifts.cols(), 3);
        EXPECT_LT(found.shifts.maxCoeff(),
                  0.02); // what keeps shells on a line from telling costs that
        EXPECT_GE(found.shifts.minCoeff(), 0.0);
    }
}

TEST(VertexShifts, AreWhatAVertexMovedInThePlaneOfItsNeighboursByTheirMeanDistance)
{
    test::TestMesh flat = test::open_patch(8, 1);
    flat.points.col(2).setZero();
    std::vector<Points> meshes(5, flat.points);
    const int middle = 4 * 9 + 4;
    double radius = 0.0;
    const auto spokes = flat.topology.spokes(middle);
    Eigen::RowVector3d centre = Eigen::RowVector3d::Zero();
    for (const Topology::Spoke& spoke : spokes)
        centre += flat.points.row(spoke.vertex) / static_cast<double>(spokes.size());
    for (const Topology::Spoke& spoke : spokes)
        radius +=
            (flat.points.row(spoke.vertex) - centre).norm() / static_cast<double>(spokes.size());
    meshes[2](middle, 0) += 0.8 * radius;
    meshes[3](middle, 2) += 0.8 * radius; // off the plane: no shift
    const VertexShifts found = vertex_shifts(flat.topology, meshes, 1, 1000);
    EXPECT_NEAR(found.shifts(middle, 2), 0.8, 1e-3);
    EXPECT_NEAR(found.shifts(middle, 3), 0.0, 1e-3);
    EXPECT_NEAR(found.shifts(middle, 0), 0.0, 1e-3);
    EXPECT_NEAR(found.heights(middle, 2), 0.0, 1e-12);
    EXPECT_NEAR(found.heights(middle, 3), 0.8, 1e-12);
    EXPECT_NEAR(found.heights(middle, 0), 0.0, 1e-12);
}

TEST(VertexShifts, AreThoseOfSomeVerticesAndOfShellsOfThree)
{
    const test::TestMesh sphere = test::icosphere(2);
    const std::vector<Points> meshes(2, sphere.points);
    const VertexShifts some = vertex_shifts(sphere.topology, meshes, 1, 20);
    EXPECT_EQ(some.vertices.size(), 20U);
    EXPECT_EQ(some.shifts.rows(), 20);
    const VertexShifts all = vertex_shifts(sphere.topology, meshes, 1, 1000);
    EXPECT_EQ(some.shifts(3, 0), all.shifts(some.vertices[3], 0));
    const test::TestMesh tetrahedron = test::tetrahedron();
    EXPECT_TRUE(vertex_shifts(tetrahedron.topology, std::vector{tetrahedron.points}, 2, 9)
                    .vertices.empty());
    // Nothing has a size there.
    EXPECT_EQ(vertex_shifts(sphere.topology, std::vector<Points>(3, 0.0 * sphere.points), 1, 99)
                  .shifts.cwiseAbs()
                  .maxCoeff(),
              0.0);
}

} // namespace
} // namespace shape
