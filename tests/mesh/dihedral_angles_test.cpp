// SPDX-License-Identifier: MIT

#include "libshape/mesh/dihedral_angles.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "libshape/base/error.h"
#include "tests/support/meshes.h"

namespace shape {
namespace {

using std::numbers::pi;

TEST(DihedralAngle, IsTheAngleByWhichAHingeWasBent)
{
    // Seen from above, the edge runs along y; the left wing is flat, the right one is bent down.
    const Eigen::Vector3d a(0, -1, 0);
    const Eigen::Vector3d b(0, 2, 0);
    const Eigen::Vector3d c(-1, 0.5, 0);
    for (int step = -179; step <= 180; ++step) {
        const double angle = step * pi / 180.0;
        const Eigen::Vector3d d(2.0 * std::cos(angle), 0.1, -2.0 * std::sin(angle));
        EXPECT_NEAR(dihedral_angle(a, b, c, d), angle, 1e-14);
    }
    EXPECT_EQ(dihedral_angle(a, b, c, Eigen::Vector3d(-1, 0, 0.0)), pi);
    EXPECT_EQ(dihedral_angle(a, b, c, Eigen::Vector3d(-1, 0, -0.0)), pi);
}

TEST(DihedralAngle, IsZeroWhereAFaceHasNoArea)
{
    const Eigen::Vector3d a(0, 0, 0);
    const Eigen::Vector3d b(0, 1, 0);
    const Eigen::Vector3d on_edge(0, 0.5, 0);
    for (const double x : {-1.0, 1.0})
        for (const double z : {-1.0, 1.0}) {
            EXPECT_EQ(dihedral_angle(a, b, on_edge, {x, 0, z}), 0.0);
            EXPECT_EQ(dihedral_angle(a, b, {x, 0, z}, on_edge), 0.0);
        }
    EXPECT_EQ(dihedral_angle(a, a, b, on_edge), 0.0);
}

TEST(DihedralAngles, AreThoseOfTheHingesAndNegatedByAMirror)
{
    for (const test::TestMesh& mesh : test::sample_meshes()) {
        SCOPED_TRACE(mesh.name);
        const Topology& t = mesh.topology;
        const Eigen::VectorXd angles = dihedral_angles(t, mesh.points);
        const auto point = [&](int v) -> Eigen::Vector3d { return mesh.points.row(v); };
        for (int e = 0; e < t.edge_count(); ++e) {
            if (t.is_boundary_edge(e)) {
                EXPECT_EQ(angles[e], 0.0);
                continue;
            }
            const int left = t.edge_halfedges()(e, 0);
            const int right = t.edge_halfedges()(e, 1);
            EXPECT_NEAR(angles[e],
                        dihedral_angle(point(t.source(left)), point(t.target(left)),
                                       point(t.source(Topology::previous(left))),
                                       point(t.source(Topology::previous(right)))),
                        1e-12);
        }
        const Points mirror = mesh.points * Eigen::Vector3d(1, -1, 1).asDiagonal();
        EXPECT_LE((dihedral_angles(t, mirror) + angles).cwiseAbs().maxCoeff(), 1e-12);
        EXPECT_LE((dihedral_angles(t, test::moved(mesh.points, 1)) - angles).cwiseAbs().maxCoeff(),
                  1e-12);
    }
}

TEST(DihedralAngles, RefuseAnotherNumberOfPoints)
{
    EXPECT_THROW((void)dihedral_angles(test::tetrahedron().topology, Points::Zero(5, 3)),
                 InvalidInput);
}

TEST(WrappedAngle, DiffersByAMultipleOfTwoPiAndLiesInTheHalfOpenRange)
{
    EXPECT_EQ(wrapped_angle(pi), pi);
    EXPECT_EQ(wrapped_angle(-pi), pi);
    EXPECT_EQ(wrapped_angle(0.0), 0.0);
    for (int i = -400; i <= 400; ++i) {
        const double angle = 0.1 * i;
        const double wrapped = wrapped_angle(angle);
        EXPECT_TRUE(wrapped > -pi && wrapped <= pi) << angle;
        EXPECT_NEAR(std::remainder(angle - wrapped, 2.0 * pi), 0.0, 1e-13);
    }
}

} // namespace
} // namespace shape
