// SPDX-License-Identifier: MIT

#include "libshape/embedding/closure/closure.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "libshape/base/error.h"
#include "libshape/base/random.h"
#include "libshape/base/threads.h"
#include "libshape/base/to_size.h"
#include "libshape/embedding/start/local_frames.h"
#include "libshape/mesh/dihedral_angles.h"
#include "libshape/mesh/edge_lengths.h"
#include "tests/support/ladybug.h"
#include "tests/support/meshes.h"

namespace shape {
using namespace internal;
namespace {

Eigen::VectorXd perturbed(Eigen::VectorXd angles, double size, unsigned seed)
{
    Random random(seed);
    for (double& angle : angles)
        angle += size * random.normal();
    return angles;
}

Points corners(const test::TestMesh& mesh)
{
    return corner_angles(mesh.topology, edge_lengths(mesh.topology, mesh.points));
}

double energy(const test::TestMesh& mesh, const Eigen::VectorXd& angles)
{
    Eigen::VectorXd gradient(angles.size());
    return ClosureEnergy(mesh.topology, corners(mesh)).evaluate(angles, gradient);
}

/// Half-edge frames from positions: x along the half-edge, z normal to its face.
Eigen::Matrix3d frame_of_points(const test::TestMesh& mesh, int h)
{
    const auto point = [&](int v) -> Eigen::Vector3d { return mesh.points.row(v).transpose(); };
    const Eigen::Vector3d origin = point(mesh.topology.source(h));
    const Eigen::Vector3d x = (point(mesh.topology.target(h)) - origin).normalized();
    const Eigen::Vector3d apex = point(mesh.topology.source(Topology::previous(h)));
    const Eigen::Vector3d z = x.cross(apex - origin).normalized();
    Eigen::Matrix3d frame;
    frame << x, z.cross(x), z;
    return frame;
}

TEST(LocalFrames, AreThoseOfTheMeshTheAnglesComeFrom)
{
    for (const test::TestMesh& mesh : test::sample_meshes()) {
        SCOPED_TRACE(mesh.name);
        const Topology& t = mesh.topology;
        const auto frames = halfedge_frames(t, corners(mesh), dihedral_angles(t, mesh.points));
        for (int v = 0; v < t.vertex_count(); ++v) {
            const Eigen::Matrix3d global = frame_of_points(mesh, t.outgoing(v).front());
            for (const int h : t.outgoing(v))
                EXPECT_LT((global * frames[to_size(h)] - frame_of_points(mesh, h)).norm(), 1e-12);
        }
    }
}

TEST(LocalFrames, TransitionsTakeTheFrameOfOneEndToThatOfTheOther)
{
    for (const test::TestMesh& mesh : test::sample_meshes()) {
        SCOPED_TRACE(mesh.name);
        const Topology& t = mesh.topology;
        const auto transitions = frame_transitions(
            t, corners(mesh), halfedge_frames(t, corners(mesh), dihedral_angles(t, mesh.points)));
        for (int e = 0; e < t.edge_count(); ++e) {
            const int h = t.edge_halfedges()(e, 0);
            const Eigen::Matrix3d v = frame_of_points(mesh, t.outgoing(t.source(h)).front());
            const Eigen::Matrix3d u = frame_of_points(mesh, t.outgoing(t.target(h)).front());
            EXPECT_LT((v * transitions[to_size(e)] - u).norm(), 1e-12);
        }
    }
}

TEST(LocalFrames, RefuseArraysOfWrongSize)
{
    const test::TestMesh mesh = test::tetrahedron();
    const Points angles = corners(mesh);
    const Eigen::VectorXd bends = dihedral_angles(mesh.topology, mesh.points);
    EXPECT_THROW((void)halfedge_frames(mesh.topology, angles.topRows(3), bends), InvalidInput);
    EXPECT_THROW((void)halfedge_frames(mesh.topology, angles, bends.head(5)), InvalidInput);
    const auto frames = halfedge_frames(mesh.topology, angles, bends);
    EXPECT_THROW((void)frame_transitions(mesh.topology, angles.topRows(3), frames), InvalidInput);
    EXPECT_THROW((void)frame_transitions(mesh.topology, angles, {}), InvalidInput);
}

TEST(ClosureEnergy, VanishesAtTheAnglesOfAMesh)
{
    for (const test::TestMesh& mesh : test::sample_meshes()) {
        SCOPED_TRACE(mesh.name);
        const Eigen::VectorXd angles = dihedral_angles(mesh.topology, mesh.points);
        EXPECT_LT(energy(mesh, angles), 1e-24);
        EXPECT_LT(energy(mesh, -angles), 1e-24) << "the mirror image";
        EXPECT_GT(energy(mesh, perturbed(angles, 0.1, 1)), 1e-2);
    }
}

TEST(ClosureEnergy, OfAFlatFanIsThatOfItsMissingAngle)
{
    // Without bending the walk is one turn about z by the sum of the corner angles.
    const test::TestMesh mesh = test::tetrahedron();
    const Eigen::VectorXd flat = Eigen::VectorXd::Zero(6);
    EXPECT_NEAR(energy(mesh, flat), 4 * 4.0 * (1.0 - std::cos(std::numbers::pi)), 1e-13);
}

TEST(ClosureEnergy, IsTheSumOfSquaresOfTheExplicitProducts)
{
    for (const test::TestMesh& mesh : test::sample_meshes()) {
        SCOPED_TRACE(mesh.name);
        const Topology& t = mesh.topology;
        const Points angles = corners(mesh);
        const Eigen::VectorXd bends = perturbed(dihedral_angles(t, mesh.points), 0.3, 7);
        double sum = 0.0;
        for (int v = 0; v < t.vertex_count(); ++v) {
            if (t.is_boundary_vertex(v))
                continue;
            const Eigen::Matrix3d walk = test::walk_around(t, angles, bends, v);
            const double squares = (walk - Eigen::Matrix3d::Identity()).squaredNorm();
            EXPECT_NEAR(4.0 * (1.0 - std::cos(Eigen::AngleAxisd(walk).angle())), squares, 1e-13);
            sum += squares;
        }
        EXPECT_NEAR(energy(mesh, bends), sum, 1e-13 * sum);
    }
}

TEST(ClosureEnergy, IsTheSameWithoutItsGradient)
{
    for (const test::TestMesh& mesh : test::sample_meshes()) {
        SCOPED_TRACE(mesh.name);
        const Eigen::VectorXd lengths = edge_lengths(mesh.topology, mesh.points);
        const Eigen::VectorXd angles =
            perturbed(dihedral_angles(mesh.topology, mesh.points), 0.3, 4);
        const double value = energy(mesh, angles);
        EXPECT_NEAR(closure_energy(mesh.topology, lengths, angles), value, 1e-12 * value);
        EXPECT_THROW((void)closure_energy(mesh.topology, lengths, angles.head(2)), InvalidInput);
    }
}

TEST(ClosureEnergy, GradientAgreesWithCentralDifferences)
{
    for (const test::TestMesh& mesh : test::sample_meshes()) {
        SCOPED_TRACE(mesh.name);
        ClosureEnergy closure(mesh.topology, corners(mesh));
        const Eigen::VectorXd angles =
            perturbed(dihedral_angles(mesh.topology, mesh.points), 0.3, 3);
        Eigen::VectorXd gradient(angles.size());
        Eigen::VectorXd unused(angles.size());
        closure.evaluate(angles, gradient);
        const double step = 1e-5;
        for (Eigen::Index e = 0; e < angles.size(); ++e) {
            Eigen::VectorXd up = angles;
            Eigen::VectorXd down = angles;
            up[e] += step;
            down[e] -= step;
            const double difference =
                (closure.evaluate(up, unused) - closure.evaluate(down, unused)) / (2.0 * step);
            EXPECT_NEAR(gradient[e], difference, 1e-7) << "edge " << e;
            if (mesh.topology.is_boundary_edge(static_cast<int>(e))) {
                EXPECT_EQ(gradient[e], 0.0);
            }
        }
    }
}

TEST(ClosureEnergy, HasTheSameBitsForAnyNumberOfThreads)
{
    const test::TestMesh mesh = test::bumpy_sphere(4, 0.3, 2);
    const Eigen::VectorXd angles = perturbed(dihedral_angles(mesh.topology, mesh.points), 0.3, 3);
    ClosureEnergy closure(mesh.topology, corners(mesh));
    Eigen::VectorXd one(angles.size());
    Eigen::VectorXd four(angles.size());
    const int before = thread_count();
    set_thread_count(1);
    const double energy_of_one = closure.evaluate(angles, one);
    set_thread_count(4);
    const double energy_of_four = closure.evaluate(angles, four);
    set_thread_count(before);
    EXPECT_EQ(energy_of_one, energy_of_four);
    EXPECT_EQ(one, four);
}

TEST(ClosureEnergy, IgnoresWholeTurns)
{
    const test::TestMesh mesh = test::torus(9, 16);
    const Eigen::VectorXd angles = perturbed(dihedral_angles(mesh.topology, mesh.points), 0.3, 3);
    Eigen::VectorXd turned = angles;
    for (Eigen::Index e = 0; e < turned.size(); ++e)
        turned[e] += 2.0 * std::numbers::pi * static_cast<double>(e % 7 - 3);
    EXPECT_NEAR(energy(mesh, turned), energy(mesh, angles), 1e-12 * energy(mesh, angles));
}

TEST(ClosureEnergy, RefusesArraysOfWrongSize)
{
    const test::TestMesh mesh = test::tetrahedron();
    const Points angles = corners(mesh);
    EXPECT_THROW(ClosureEnergy(mesh.topology, angles.topRows(3)), InvalidInput);
    ClosureEnergy closure(mesh.topology, angles);
    Eigen::VectorXd gradient(6);
    EXPECT_THROW(closure.evaluate(Eigen::VectorXd::Zero(5), gradient), InvalidInput);
    Eigen::VectorXd too_short(5);
    EXPECT_THROW(closure.evaluate(Eigen::VectorXd::Zero(6), too_short), InvalidInput);
}

} // namespace
} // namespace shape
