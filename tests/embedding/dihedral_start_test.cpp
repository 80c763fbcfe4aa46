// SPDX-License-Identifier: MIT

// The steps of the linear start: layout, frames, positions, wedges.

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "libshape/base/error.h"
#include "libshape/base/random.h"
#include "libshape/embedding/edge_laplacian.h"
#include "libshape/embedding/face_fit.h"
#include "libshape/embedding/face_layout.h"
#include "libshape/embedding/patch_frames.h"
#include "libshape/mesh/alignment.h"
#include "libshape/mesh/dihedral_angles.h"
#include "libshape/mesh/edge_lengths.h"
#include "tests/support/ladybug.h"
#include "tests/support/meshes.h"

namespace shape {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;

FaceLayout layout_of(const test::TestMesh& mesh)
{
    const VectorXd lengths = edge_lengths(mesh.topology, mesh.points);
    return lay_out_faces(mesh.topology, lengths, dihedral_angles(mesh.topology, mesh.points));
}

/// The frames as positions have them: x along half-edge 3 f, z the outward normal.
std::vector<Matrix3d> frames_of(const test::TestMesh& mesh)
{
    std::vector<Matrix3d> frames;
    for (int f = 0; f < mesh.topology.face_count(); ++f) {
        const auto point = [&](int c) -> Vector3d {
            return mesh.points.row(mesh.topology.faces()(f, c)).transpose();
        };
        Matrix3d frame;
        frame.col(0) = (point(1) - point(0)).normalized();
        frame.col(2) = (point(1) - point(0)).cross(point(2) - point(0)).normalized();
        frame.col(1) = frame.col(2).cross(frame.col(0));
        frames.push_back(frame);
    }
    return frames;
}

double largest_difference(const std::vector<Matrix3d>& a, const std::vector<Matrix3d>& b)
{
    double largest = 0.0;
    for (std::size_t i = 0; i < a.size(); ++i)
        largest = std::max(largest, (a[i] - b[i]).cwiseAbs().maxCoeff());
    return largest;
}

TEST(FaceLayout, AgreesWithTheMeshItIsOf)
{
    for (const test::TestMesh& mesh : test::sample_meshes()) {
        SCOPED_TRACE(mesh.name);
        const Topology& t = mesh.topology;
        const FaceLayout layout = layout_of(mesh);
        const std::vector<Matrix3d> frames = frames_of(mesh);
        for (int h = 0; h < t.halfedge_count(); ++h) {
            const Vector3d edge = (mesh.points.row(t.target(h)) - mesh.points.row(t.source(h)));
            EXPECT_LT(
                (frames[static_cast<std::size_t>(h / 3)] * layout.halfedges.row(h).transpose() -
                 edge)
                    .norm(),
                1e-12);
        }
        for (int e = 0; e < t.edge_count(); ++e) {
            if (t.is_boundary_edge(e))
                continue;
            const auto left = static_cast<std::size_t>(t.edge_halfedges()(e, 0) / 3);
            const auto right = static_cast<std::size_t>(t.edge_halfedges()(e, 1) / 3);
            EXPECT_LT(
                (frames[left] * layout.transitions[static_cast<std::size_t>(e)] - frames[right])
                    .norm(),
                1e-12);
        }
    }
}

TEST(ClosureCosines, AreThoseOfTheWalksAroundVertices)
{
    Random random(4);
    for (const test::TestMesh& mesh : test::sample_meshes()) {
        SCOPED_TRACE(mesh.name);
        const Topology& t = mesh.topology;
        const VectorXd lengths = edge_lengths(t, mesh.points);
        VectorXd angles = dihedral_angles(t, mesh.points);
        const FaceLayout closed = lay_out_faces(t, lengths, angles);
        EXPECT_GT(closure_cosines(t, closed.transitions).minCoeff(), 1.0 - 1e-12);
        for (int e = 0; e < t.edge_count(); ++e)
            if (!t.is_boundary_edge(e))
                angles[e] += random.uniform(-1.0, 1.0);
        const FaceLayout open = lay_out_faces(t, lengths, angles);
        const VectorXd cosines = closure_cosines(t, open.transitions);
        for (int v = 0; v < t.vertex_count(); ++v) {
            const Matrix3d walk = t.is_boundary_vertex(v)
                                      ? Matrix3d::Identity()
                                      : test::walk_around(t, corner_angles(t, lengths), angles, v);
            EXPECT_NEAR(cosines[v], 0.5 * (walk.trace() - 1.0), 1e-12);
        }
    }
}

TEST(PatchFrames, OrientAMeshWhoseLoopsClose)
{
    std::vector<test::TestMesh> meshes = test::sample_meshes();
    meshes.push_back(test::bumpy_sphere(4, 0.3, 2));
    meshes.push_back(test::torus(20, 90));
    for (const test::TestMesh& mesh : meshes) {
        SCOPED_TRACE(mesh.name);
        const std::vector<Matrix3d> wanted = frames_of(mesh);
        std::vector<Matrix3d> frames = PatchFrames(mesh.topology)
                                           .face_frames(layout_of(mesh).transitions,
                                                        VectorXd::Ones(mesh.topology.edge_count()));
        const Matrix3d turn = wanted[0] * frames[0].transpose();
        for (Matrix3d& frame : frames)
            frame = turn * frame;
        EXPECT_LT(largest_difference(frames, wanted), 1e-9);
    }
}

TEST(PatchFrames, ATransitionWithLittleWeightDoesNotTurnTheRest)
{
    const test::TestMesh mesh = test::bumpy_sphere(3, 0.3, 2);
    const std::vector<Matrix3d> wanted = frames_of(mesh);
    FaceLayout layout = layout_of(mesh);
    VectorXd weights = VectorXd::Ones(mesh.topology.edge_count());
    Random random(8);
    for (int wild = 0; wild < 40; ++wild) {
        const auto e = random.index(static_cast<std::uint64_t>(mesh.topology.edge_count()));
        layout.transitions[e] =
            Eigen::AngleAxisd(random.uniform(1.0, 3.0), Vector3d::UnitX()).toRotationMatrix() *
            layout.transitions[e];
        weights[static_cast<Eigen::Index>(e)] = 1e-9;
    }
    std::vector<Matrix3d> frames =
        PatchFrames(mesh.topology).face_frames(layout.transitions, weights);
    const Matrix3d turn = wanted[0] * frames[0].transpose();
    for (Matrix3d& frame : frames)
        frame = turn * frame;
    // A face that hangs on its patch by a wild edge alone is lost, its neighbours are not.
    int lost = 0;
    for (std::size_t f = 0; f < frames.size(); ++f)
        if ((frames[f] - wanted[f]).norm() > 1e-6)
            ++lost;
    EXPECT_LE(lost, 12);
}

TEST(PatchFrames, RefusesWrongSizes)
{
    const test::TestMesh mesh = test::tetrahedron();
    const FaceLayout layout = layout_of(mesh);
    EXPECT_THROW(
        (void)PatchFrames(mesh.topology).face_frames(layout.transitions, VectorXd::Ones(5)),
        InvalidInput);
    EXPECT_THROW((void)lay_out_faces(mesh.topology, VectorXd::Ones(5), VectorXd::Zero(6)),
                 InvalidInput);
}

TEST(EdgeLaplacian, TakesFramesOfAMeshBackToItsPositions)
{
    for (const test::TestMesh& mesh : test::sample_meshes()) {
        SCOPED_TRACE(mesh.name);
        const VectorXd lengths = edge_lengths(mesh.topology, mesh.points);
        for (const VectorXd& weighted_by : {lengths, VectorXd(VectorXd::Ones(lengths.size()))}) {
            const EdgeLaplacian laplacian(mesh.topology, weighted_by);
            Points points = laplacian.positions(frames_of(mesh), layout_of(mesh).halfedges);
            points.rowwise() += mesh.points.row(1) - points.row(1);
            EXPECT_LT((points - mesh.points).cwiseAbs().maxCoeff(), 1e-10);
        }
    }
}

TEST(FaceFit, FindsTheFramesOfAMovedMesh)
{
    for (const test::TestMesh& mesh : test::sample_meshes()) {
        SCOPED_TRACE(mesh.name);
        const VectorXd weights =
            edge_lengths(mesh.topology, mesh.points).array().square().inverse();
        const test::TestMesh target{mesh.name, mesh.topology, test::moved(mesh.points, 11)};
        const std::vector<Matrix3d> fitted =
            fit_faces(mesh.topology, layout_of(mesh), weights, target.points, frames_of(mesh));
        EXPECT_LT(largest_difference(fitted, frames_of(target)), 1e-10);
    }
}

} // namespace
} // namespace shape
