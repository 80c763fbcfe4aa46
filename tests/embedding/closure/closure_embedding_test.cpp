// SPDX-License-Identifier: MIT

#include "libshape/embedding/closure/closure_embedding.h"

#include <gtest/gtest.h>
#include <Eigen/LU>

#include <limits>

#include "libshape/base/error.h"
#include "libshape/base/random.h"
#include "libshape/base/to_size.h"
#include "libshape/embedding/closure/vertex_frames.h"
#include "libshape/embedding/closure/vertex_positions.h"
#include "libshape/embedding/start/local_frames.h"
#include "libshape/mesh/alignment.h"
#include "libshape/mesh/dihedral_angles.h"
#include "libshape/mesh/edge_lengths.h"
#include "tests/support/meshes.h"

namespace shape {
using namespace internal;
namespace {

ShapePoint own_point(const Topology& topology, const Points& points)
{
    return {edge_lengths(topology, points), dihedral_angles(topology, points)};
}

/// Largest distance after the best rigid motion, over the bounding-box diagonal.
double rigid_distance(const Points& points, const Points& expected)
{
    const Points moved = best_rigid_motion(points, expected)(points);
    return (moved - expected).rowwise().norm().maxCoeff() / bounding_box_diagonal(expected);
}

TEST(ClosureEmbedding, RecoversAMeshFromItsLengthsAndAngles)
{
    for (const test::TestMesh& mesh : test::sample_meshes()) {
        SCOPED_TRACE(mesh.name);
        const ClosureEmbedding result =
            embed_by_closure(mesh.topology, own_point(mesh.topology, mesh.points));
        EXPECT_TRUE(result.solution.converged);
        EXPECT_LT(result.solution.energy, 1e-24);
        EXPECT_LT(rigid_distance(result.points, mesh.points), 1e-9);
        EXPECT_LT(result.points.colwise().mean().norm(), 1e-12);
    }
}

TEST(ClosureEmbedding, GivesTheMirrorImageOfNegatedAngles)
{
    for (const test::TestMesh& mesh : test::sample_meshes()) {
        SCOPED_TRACE(mesh.name);
        ShapePoint target = own_point(mesh.topology, mesh.points);
        target.dihedral_angles *= -1.0;
        const Points mirror = mesh.points * Eigen::Vector3d(1, 1, -1).asDiagonal();
        EXPECT_LT(rigid_distance(embed_by_closure(mesh.topology, target).points, mirror), 1e-9);
    }
}

TEST(ClosureEmbedding, ScalesWithTheUnitOfLength)
{
    const test::TestMesh mesh = test::bumpy_sphere(2, 0.3, 1);
    ShapePoint target = own_point(mesh.topology, mesh.points);
    Random random(1);
    for (double& angle : target.dihedral_angles)
        angle += 0.02 * random.normal();
    const Points small = embed_by_closure(mesh.topology, target).points;
    target.edge_lengths *= 1024.0;
    EXPECT_LT(
        (embed_by_closure(mesh.topology, target).points - 1024.0 * small).cwiseAbs().maxCoeff(),
        1e-9 * 1024.0);
}

TEST(ClosureEmbedding, FindsAnOpenMeshFromPerturbedAngles)
{
    // Fewer edges than degrees of freedom: the lengths are met whatever the angles end at.
    const test::TestMesh mesh = test::open_patch(10, 2);
    ShapePoint target = own_point(mesh.topology, mesh.points);
    Random random(1);
    for (double& angle : target.dihedral_angles)
        angle += 0.02 * random.normal();
    const ClosureEmbedding result = embed_by_closure(
        mesh.topology, target, {.gradient_tolerance = 1e-9, .decrease_tolerance = 0.0});
    EXPECT_TRUE(result.solution.converged);
    EXPECT_LT(result.solution.energy, 1e-14);
    const Eigen::ArrayXd lengths = edge_lengths(mesh.topology, result.points);
    EXPECT_LT((lengths / target.edge_lengths.array() - 1.0).abs().maxCoeff(), 1e-6);
}

TEST(ClosureEmbedding, RefusesLengthsThatBreakATriangleInequality)
{
    const test::TestMesh mesh = test::tetrahedron();
    ShapePoint target = own_point(mesh.topology, mesh.points);
    const int face = 2;
    target.edge_lengths[mesh.topology.face_edges()(face, 0)] *= 1.9;
    target.edge_lengths[mesh.topology.face_edges()(face, 1)] *= 0.5;
    try {
        (void)embed_by_closure(mesh.topology, target);
        FAIL() << "nothing was thrown";
    } catch (const NumericalError& error) {
        EXPECT_NE(std::string(error.what()).find("face 2"), std::string::npos) << error.what();
    }
}

TEST(ClosureEmbedding, RefusesBrokenArguments)
{
    const test::TestMesh mesh = test::tetrahedron();
    const ShapePoint target = own_point(mesh.topology, mesh.points);
    const auto with = [&](double length, double angle) {
        ShapePoint changed = target;
        changed.edge_lengths[3] = length;
        changed.dihedral_angles[4] = angle;
        return changed;
    };
    const double nan = std::numeric_limits<double>::quiet_NaN();
    EXPECT_THROW((void)embed_by_closure(mesh.topology, with(0.0, 1.0)), NumericalError);
    EXPECT_THROW((void)embed_by_closure(mesh.topology, with(-1.0, 1.0)), NumericalError);
    EXPECT_THROW((void)embed_by_closure(mesh.topology, with(nan, 1.0)), InvalidInput);
    EXPECT_THROW((void)embed_by_closure(mesh.topology, with(1.0, nan)), InvalidInput);
    EXPECT_THROW((void)embed_by_closure(mesh.topology,
                                        {target.edge_lengths.head(5), target.dihedral_angles}),
                 InvalidInput);
    EXPECT_THROW((void)embed_by_closure(mesh.topology,
                                        {target.edge_lengths, target.dihedral_angles.head(5)}),
                 InvalidInput);
    EXPECT_THROW((void)embed_by_closure(mesh.topology, target, {.memory = 0}), InvalidInput);
}

TEST(VertexFrames, AreRotationsThatSatisfyTheirEquations)
{
    for (const test::TestMesh& mesh : test::sample_meshes()) {
        SCOPED_TRACE(mesh.name);
        const Topology& t = mesh.topology;
        const ShapePoint own = own_point(t, mesh.points);
        const Points corners = corner_angles(t, own.edge_lengths);
        const auto transitions =
            frame_transitions(t, corners, halfedge_frames(t, corners, own.dihedral_angles));
        const auto frames = vertex_frames(t, transitions);
        EXPECT_EQ(frames[0], Eigen::Matrix3d::Identity());
        for (int e = 0; e < t.edge_count(); ++e) {
            const int h = t.edge_halfedges()(e, 0);
            const Eigen::Matrix3d& v = frames[to_size(t.source(h))];
            const Eigen::Matrix3d& u = frames[to_size(t.target(h))];
            EXPECT_LT((v * transitions[to_size(e)] - u).norm(), 1e-10);
        }
    }
}

TEST(VertexFrames, AreRotationsWhereNoneSatisfiesTheEquations)
{
    const test::TestMesh mesh = test::torus(9, 16);
    const Topology& t = mesh.topology;
    const Points corners = corner_angles(t, edge_lengths(t, mesh.points));
    Eigen::VectorXd angles = dihedral_angles(t, mesh.points);
    Random random(1);
    for (double& angle : angles)
        angle += 0.3 * random.normal();
    for (const Eigen::Matrix3d& frame :
         vertex_frames(t, frame_transitions(t, corners, halfedge_frames(t, corners, angles)))) {
        EXPECT_LT((frame * frame.transpose() - Eigen::Matrix3d::Identity()).norm(), 1e-13);
        EXPECT_NEAR(frame.determinant(), 1.0, 1e-13);
    }
}

TEST(VertexFrames, DoNotSeeARigidMotionOfTheMesh)
{
    const test::TestMesh mesh = test::bumpy_sphere(2, 0.3, 1);
    const auto frames = [&](const Points& points) {
        const Points corners = corner_angles(mesh.topology, edge_lengths(mesh.topology, points));
        return vertex_frames(
            mesh.topology,
            frame_transitions(
                mesh.topology, corners,
                halfedge_frames(mesh.topology, corners, dihedral_angles(mesh.topology, points))));
    };
    const auto here = frames(mesh.points);
    const auto there = frames(test::moved(mesh.points, 9));
    for (std::size_t v = 0; v < here.size(); ++v)
        EXPECT_LT((here[v] - there[v]).norm(), 1e-10);
}

TEST(VertexPositions, SatisfyTheNormalEquations)
{
    // With random frames no position fits all half-edges: at every vertex the gaps v + G u_v - u
    // balance.
    const test::TestMesh mesh = test::open_cylinder(10, 8);
    const Topology& t = mesh.topology;
    const ShapePoint own = own_point(t, mesh.points);
    const auto local = halfedge_frames(t, corner_angles(t, own.edge_lengths), own.dihedral_angles);
    Random random(2);
    std::vector<Eigen::Matrix3d> frames;
    for (int v = 0; v < t.vertex_count(); ++v)
        frames.push_back(turn_about_x(random.normal()) * turn_about_z(random.normal()));
    const Points points = vertex_positions(t, own.edge_lengths, local, frames);
    Points balance = Points::Zero(points.rows(), 3);
    double largest = 0.0;
    for (int h = 0; h < t.halfedge_count(); ++h) {
        const int v = t.source(h);
        const int u = t.target(h);
        const Eigen::Vector3d step =
            own.edge_lengths[t.edge(h)] * (frames[to_size(v)] * local[to_size(h)].col(0));
        const Eigen::RowVector3d gap = points.row(v) + step.transpose() - points.row(u);
        largest = std::max(largest, gap.norm());
        balance.row(v) += gap;
        balance.row(u) -= gap;
    }
    EXPECT_GT(largest, 0.1);
    EXPECT_LT(balance.cwiseAbs().maxCoeff(), 1e-11);
}

TEST(VertexFramesAndPositions, RefuseArraysOfWrongSize)
{
    const test::TestMesh mesh = test::tetrahedron();
    const Topology& t = mesh.topology;
    const ShapePoint own = own_point(t, mesh.points);
    const std::vector<Eigen::Matrix3d> local(12, Eigen::Matrix3d::Identity());
    const std::vector<Eigen::Matrix3d> frames(4, Eigen::Matrix3d::Identity());
    EXPECT_THROW((void)vertex_frames(t, frames), InvalidInput);
    EXPECT_THROW((void)vertex_positions(t, own.edge_lengths.head(5), local, frames), InvalidInput);
    EXPECT_THROW((void)vertex_positions(t, own.edge_lengths, frames, frames), InvalidInput);
    EXPECT_THROW((void)vertex_positions(t, own.edge_lengths, local, local), InvalidInput);
}

} // namespace
} // namespace shape
