// SPDX-License-Identifier: MIT

#include "libshape/mesh/hinge.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <array>
#include <cmath>

#include "libshape/base/random.h"
#include "libshape/linalg/eight_lanes.h"
#include "libshape/mesh/dihedral_angles.h"
#include "tests/support/meshes.h"

namespace shape {
using namespace internal;
namespace {

using Eigen::Vector3d;

using Corners = std::array<Vector3d, 4>;

Corners random_hinge(Random& random)
{
    const auto shift = [&] { return random.uniform(-0.4, 0.4); };
    const auto near = [&](double x, double y, double z) {
        return Vector3d(x + shift(), y + shift(), z + shift());
    };
    return {near(0, 0, 0), near(2, 0, 0), near(1, 1, 0), near(1, -1, 0)};
}

double angle_of_corners(const Corners& p)
{
    return dihedral_angle(p[0], p[1], p[2], p[3]);
}

/// d theta / d(one coordinate of one corner), by central differences.
double slope(Corners p, std::size_t corner, int axis)
{
    constexpr double h = 1e-6;
    p[corner][axis] += h;
    const double above = angle_of_corners(p);
    p[corner][axis] -= 2.0 * h;
    return wrapped_angle(above - angle_of_corners(p)) / (2.0 * h);
}

TEST(Hinge, HasTheDerivativesOfCentralDifferencesInAllForms)
{
    Random random(5);
    for (int sample = 0; sample < 100; ++sample) {
        const Corners p = random_hinge(random);
        const Vector3d edge = p[1] - p[0];
        const double length = edge.norm();
        const Vector3d normal = edge.cross(p[2] - p[0]);
        const double foot = foot_of(length, length * length, (p[2] - p[0]).squaredNorm(),
                                    (p[2] - p[1]).squaredNorm());
        EXPECT_NEAR(foot, (p[2] - p[0]).dot(edge) / length, 1e-13);
        const HingeShares<double> shares = hinge_shares(length, foot);
        const HingeSlopes<double> slopes =
            hinge_slopes(vector3(edge.data()), vector3(Vector3d(p[0] - p[2]).data()),
                         length * length, 1.0 / normal.norm());
        const double height = normal.norm() / length;
        EXPECT_NEAR(slopes.height, 1.0 / height, 1e-12 / height);
        for (int axis = 0; axis < 3; ++axis) {
            // The corner opposite the edge belongs to one triangle alone.
            EXPECT_NEAR(slope(p, 2, axis), shares.c * normal[axis] / normal.squaredNorm(), 1e-7);
            const double along = normal[axis] / normal.norm();
            EXPECT_NEAR(slope(p, 2, axis), bend_by_slopes(slopes, 0.0, 0.0, along), 1e-7);
            EXPECT_NEAR(
                length * slope(p, 2, axis),
                bend_by_cotangents(foot / height, (length - foot) / height, 0.0, 0.0, along), 1e-7);
        }
        // The forms agree for any motion.
        const double a = random.uniform(-1, 1), b = random.uniform(-1, 1),
                     c = random.uniform(-1, 1);
        const double bend = (shares.a * a + shares.b * b + shares.c * c) / normal.norm();
        EXPECT_NEAR(bend_by_slopes(slopes, a, b, c), bend, 1e-12 * (1.0 + std::abs(bend)));
        EXPECT_NEAR(bend_by_cotangents(foot / height, (length - foot) / height, a, b, c),
                    length * bend, 1e-12 * (1.0 + std::abs(bend)));
    }
}

TEST(Hinge, HasTheDerivativesOfItsEdgesEndsFromBothTriangles)
{
    Random random(6);
    for (int sample = 0; sample < 100; ++sample) {
        const Corners p = random_hinge(random);
        const Vector3d edge = p[1] - p[0];
        const double length = edge.norm();
        const auto normals =
            hinge_normals(vector3(edge.data()), vector3(Vector3d(p[2] - p[0]).data()),
                          vector3(Vector3d(p[3] - p[0]).data()));
        std::array<Vector3d, 2> ends{Vector3d::Zero(), Vector3d::Zero()};
        for (const auto& [normal, apex] : {std::pair(normals.left, p[2]), {normals.right, p[3]}}) {
            const HingeShares<double> shares =
                hinge_shares(length, (apex - p[0]).dot(edge) / length);
            const Vector3d n = Vector3d(normal.x, normal.y, normal.z) / dot(normal, normal);
            ends[0] += shares.a * n;
            ends[1] += shares.b * n;
        }
        for (std::size_t end : {0U, 1U})
            for (int axis = 0; axis < 3; ++axis)
                EXPECT_NEAR(slope(p, end, axis), ends[end][axis], 1e-7);
    }
}

TEST(Hinge, TurnsAnglesBackByOthers)
{
    Random random(7);
    for (int sample = 0; sample < 100; ++sample) {
        const double angle = random.uniform(-3.1, 3.1);
        const double other = random.uniform(-3.1, 3.1);
        const double size = random.uniform(0.1, 10.0);
        const AngleVector<double> vector{size * std::sin(angle), size * std::cos(angle)};
        EXPECT_NEAR(angle_of(vector), angle, 1e-14);
        EXPECT_NEAR(wrapped_angle(angle_of(turned_back(vector, std::sin(other), std::cos(other))) -
                                  angle + other),
                    0.0, 1e-13);
    }
    EXPECT_EQ(angle_of({0.0, 0.0}), 0.0);
    EXPECT_EQ(angle_of({0.0, -0.0}), 0.0);
    EXPECT_GT(angle_of({-0.0, -1.0}), 3.0); // pi, not -pi
}

TEST(Hinge, IsTheSameInEightLanesButForRounding)
{
    Random random(8);
    std::array<Corners, EightLanes::lanes> hinges;
    std::array<EightLanePoint, 4> p{};
    for (std::size_t k = 0; k < EightLanes::lanes; ++k) {
        hinges[k] = random_hinge(random);
        for (std::size_t corner = 0; corner < 4; ++corner) {
            p[corner].x.of[k] = static_cast<float>(hinges[k][corner].x());
            p[corner].y.of[k] = static_cast<float>(hinges[k][corner].y());
            p[corner].z.of[k] = static_cast<float>(hinges[k][corner].z());
        }
    }
    const EightLanePoint edge = p[1] - p[0];
    const EightLanes length = sqrt(dot(edge, edge));
    const auto normals = hinge_normals(edge, p[2] - p[0], p[3] - p[0]);
    const auto angle = hinge_angle(edge, length, normals.left, normals.right);
    for (std::size_t k = 0; k < EightLanes::lanes; ++k)
        EXPECT_NEAR(std::atan2(angle.sine.of[k], angle.cosine.of[k]), angle_of_corners(hinges[k]),
                    1e-5);
}

TEST(Hinge, HasItsCornersInTheOrderOfTheEdge)
{
    for (const test::TestMesh& mesh : test::sample_meshes()) {
        SCOPED_TRACE(mesh.name);
        const Topology& t = mesh.topology;
        const Eigen::VectorXd angles = dihedral_angles(t, mesh.points);
        for (int e = 0; e < t.edge_count(); ++e) {
            const std::array<int, 4> hinge = hinge_corners(t, e);
            EXPECT_EQ(t.find_edge(hinge[0], hinge[1]), e);
            ASSERT_EQ(hinge[3] < 0, t.is_boundary_edge(e));
            if (hinge[3] < 0)
                continue;
            const auto point = [&](int v) -> Vector3d { return mesh.points.row(v); };
            EXPECT_NEAR(
                wrapped_angle(angles[e] - angle_of_corners({point(hinge[0]), point(hinge[1]),
                                                            point(hinge[2]), point(hinge[3])})),
                0.0, 1e-12);
        }
    }
}

} // namespace
} // namespace shape
