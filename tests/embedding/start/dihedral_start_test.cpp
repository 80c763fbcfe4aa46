// SPDX-License-Identifier: MIT

// The steps of the linear start: layout, patches, frames, positions, face fits.

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <memory>
#include <utility>

#include "libshape/base/error.h"
#include "libshape/base/random.h"
#include "libshape/base/to_size.h"
#include "libshape/embedding/start/edge_laplacian.h"
#include "libshape/embedding/start/face_fit.h"
#include "libshape/embedding/start/face_layout.h"
#include "libshape/embedding/start/patch_frames.h"
#include "libshape/mesh/alignment.h"
#include "libshape/mesh/dihedral_angles.h"
#include "libshape/mesh/edge_lengths.h"
#include "libshape/mesh/face_patches.h"
#include "tests/support/ladybug.h"
#include "tests/support/meshes.h"

namespace shape {
using namespace internal;
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
Rotations frames_of(const test::TestMesh& mesh)
{
    Rotations frames;
    for (int f = 0; f < mesh.topology.face_count(); ++f) {
        const auto point = [&](int c) -> Vector3d {
            return mesh.points.row(mesh.topology.faces()(f, c)).transpose();
        };
        Matrix3d frame;
        frame.col(0) = (point(1) - point(0)).normalized();
        frame.col(2) = (point(1) - point(0)).cross(point(2) - point(0)).normalized();
        frame.col(1) = frame.col(2).cross(frame.col(0));
        frames.emplace_back(frame);
    }
    return frames;
}

double difference(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b)
{
    return (a.toRotationMatrix() - b.toRotationMatrix()).cwiseAbs().maxCoeff();
}

double largest_difference(const Rotations& a, const Rotations& b)
{
    double largest = 0.0;
    for (std::size_t i = 0; i < a.size(); ++i)
        largest = std::max(largest, difference(a[i], b[i]));
    return largest;
}

/// Frames of all faces in patches, turned so that the first one is as wanted.
Rotations patch_frames(const test::TestMesh& mesh, const Rotations& transitions,
                       const VectorXd& weights, const Rotations& wanted)
{
    Rotations frames = PatchFrames(std::make_shared<FacePatches>(mesh.topology, 64))
                           .face_frames(transitions, weights);
    const Eigen::Quaterniond turn = wanted[0] * frames[0].conjugate();
    for (Eigen::Quaterniond& frame : frames)
        frame = turn * frame;
    return frames;
}

TEST(FaceLayout, AgreesWithTheMeshItIsOf)
{
    for (const test::TestMesh& mesh : test::sample_meshes()) {
        SCOPED_TRACE(mesh.name);
        const Topology& t = mesh.topology;
        const FaceLayout layout = layout_of(mesh);
        const Rotations frames = frames_of(mesh);
        for (int h = 0; h < t.halfedge_count(); ++h) {
            const Vector3d edge = (mesh.points.row(t.target(h)) - mesh.points.row(t.source(h)));
            Vector3d side = Vector3d::Zero();
            side.head<2>() = layout.halfedge(h);
            EXPECT_LT((frames[to_size(h / 3)] * side - edge).norm(), 1e-12);
        }
        for (int e = 0; e < t.edge_count(); ++e) {
            if (t.is_boundary_edge(e))
                continue;
            const auto left = to_size(t.edge_halfedges()(e, 0) / 3);
            const auto right = to_size(t.edge_halfedges()(e, 1) / 3);
            EXPECT_LT(difference(frames[left] * layout.transitions[to_size(e)], frames[right]),
                      1e-12);
        }
    }
}

TEST(ClosureAngles, AreThoseOfTheWalksAroundVertices)
{
    Random random(4);
    for (const test::TestMesh& mesh : test::sample_meshes()) {
        SCOPED_TRACE(mesh.name);
        const Topology& t = mesh.topology;
        const VectorXd lengths = edge_lengths(t, mesh.points);
        VectorXd angles = dihedral_angles(t, mesh.points);
        const FaceLayout closed = lay_out_faces(t, lengths, angles);
        EXPECT_LT(closure_angles(t, closed.transitions).maxCoeff(), 1e-12);
        for (int e = 0; e < t.edge_count(); ++e)
            if (!t.is_boundary_edge(e))
                angles[e] += random.uniform(-1.0, 1.0);
        const FaceLayout open = lay_out_faces(t, lengths, angles);
        const VectorXd found = closure_angles(t, open.transitions);
        for (int v = 0; v < t.vertex_count(); ++v) {
            const Matrix3d walk = t.is_boundary_vertex(v)
                                      ? Matrix3d::Identity()
                                      : test::walk_around(t, corner_angles(t, lengths), angles, v);
            EXPECT_NEAR(std::cos(found[v]), 0.5 * (walk.trace() - 1.0), 1e-12);
        }
    }
}

TEST(FacePatches, HoldEveryFaceOnceAndAreConnected)
{
    std::vector<test::TestMesh> meshes = test::sample_meshes();
    meshes.push_back(test::bumpy_sphere(4, 0.3, 2));
    meshes.push_back(test::torus(20, 90));
    for (const test::TestMesh& mesh : meshes) {
        SCOPED_TRACE(mesh.name);
        const FacePatches patches(mesh.topology, 64);
        std::vector<int> faces = patches.faces;
        std::sort(faces.begin(), faces.end());
        for (int f = 0; f < mesh.topology.face_count(); ++f)
            ASSERT_EQ(faces[to_size(f)], f);
        std::size_t ways_inside = 0;
        for (int p = 0; p < patches.count(); ++p) {
            EXPECT_GE(patches.size(p), std::min(8, mesh.topology.face_count()));
            std::vector<int> reached{0};
            std::vector<char> seen(to_size(patches.size(p)), 0);
            seen[0] = 1;
            for (std::size_t i = 0; i < reached.size(); ++i)
                for (int c = 0; c < 3; ++c) {
                    const int way = 3 * (patches.begin(p) + reached[i]) + c;
                    const int next = patches.ways[to_size(way)].neighbour;
                    ways_inside += next >= 0;
                    if (next >= 0 && !std::exchange(seen[to_size(next)], 1))
                        reached.push_back(next);
                }
            EXPECT_EQ(static_cast<int>(reached.size()), patches.size(p));
        }
        std::size_t interior = 0;
        for (int e = 0; e < mesh.topology.edge_count(); ++e)
            interior += !mesh.topology.is_boundary_edge(e);
        EXPECT_EQ(ways_inside + 2 * patches.bridges.size(), 2 * interior);
    }
}

TEST(PatchFrames, OrientAMeshWhoseLoopsClose)
{
    std::vector<test::TestMesh> meshes = test::sample_meshes();
    meshes.push_back(test::bumpy_sphere(4, 0.3, 2));
    meshes.push_back(test::torus(20, 90));
    for (const test::TestMesh& mesh : meshes) {
        SCOPED_TRACE(mesh.name);
        const Rotations wanted = frames_of(mesh);
        const Rotations frames = patch_frames(mesh, layout_of(mesh).transitions,
                                              VectorXd::Ones(mesh.topology.edge_count()), wanted);
        EXPECT_LT(largest_difference(frames, wanted), 1e-9);
    }
}

TEST(PatchFrames, ATransitionWithLittleWeightDoesNotTurnTheRest)
{
    const test::TestMesh mesh = test::bumpy_sphere(3, 0.3, 2);
    const Rotations wanted = frames_of(mesh);
    FaceLayout layout = layout_of(mesh);
    VectorXd weights = VectorXd::Ones(mesh.topology.edge_count());
    Random random(8);
    for (int wild = 0; wild < 40; ++wild) {
        const auto e = random.index(static_cast<std::uint64_t>(mesh.topology.edge_count()));
        layout.transitions[e] =
            Eigen::AngleAxisd(random.uniform(1.0, 3.0), Vector3d::UnitX()) * layout.transitions[e];
        weights[static_cast<Eigen::Index>(e)] = 1e-9;
    }
    const Rotations frames = patch_frames(mesh, layout.transitions, weights, wanted);
    // A face that hangs on its patch by a wild edge alone is lost, its neighbours are not.
    int lost = 0;
    for (std::size_t f = 0; f < frames.size(); ++f)
        if (difference(frames[f], wanted[f]) > 1e-6)
            ++lost;
    EXPECT_LE(lost, 12);
}

TEST(PatchFrames, OrientAMeshByItsTurns)
{
    for (const test::TestMesh& mesh : test::sample_meshes()) {
        SCOPED_TRACE(mesh.name);
        Points reference = mesh.points;
        for (auto row : reference.rowwise())
            row += Eigen::RowVector3d(0.3 * row.y() * row.y(), 0.2 * row.y(), 0.4 * row.x());
        const ReferencePatches patches(mesh.topology, reference);
        const FaceLayout layout = layout_of(mesh);
        const Rotations wanted = frames_of(mesh);
        VectorXd turns(3 * static_cast<Eigen::Index>(patches.patches.pairs.size()));
        for (std::size_t k = 0; k < patches.patches.pairs.size(); ++k) {
            const auto& pair = patches.patches.pairs[k];
            turns.segment<3>(3 * static_cast<Eigen::Index>(k)) =
                rotation_vector(patches.rotation(pair.lower, wanted).conjugate() *
                                patches.rotation(pair.higher, wanted));
        }
        PatchFrames orient(
            std::shared_ptr<const FacePatches>(std::shared_ptr<void>(), &patches.patches));
        const VectorXd weights = VectorXd::Ones(mesh.topology.edge_count());
        const PatchTurning turning{patches, turns, 1.0};
        Rotations frames = orient.face_frames(layout.transitions, weights, {}, &turning);
        const Eigen::Quaterniond turn = wanted[0] * frames[0].conjugate();
        for (Eigen::Quaterniond& frame : frames)
            frame = turn * frame;
        EXPECT_LT(largest_difference(frames, wanted), 1e-6);
        const VectorXd too_many = VectorXd::Zero(turns.size() + 1);
        const PatchTurning wrong{patches, too_many, 1.0};
        EXPECT_THROW((void)orient.face_frames(layout.transitions, weights, {}, &wrong),
                     InvalidInput);
    }
}

TEST(PatchFrames, RefusesWrongSizes)
{
    const test::TestMesh mesh = test::tetrahedron();
    const FaceLayout layout = layout_of(mesh);
    EXPECT_THROW((void)PatchFrames(std::make_shared<FacePatches>(mesh.topology, 64))
                     .face_frames(layout.transitions, VectorXd::Ones(5)),
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
            const FaceLayout layout = layout_of(mesh);
            const Rotations frames = frames_of(mesh);
            Points points = laplacian.positions(layout, frames);
            points.rowwise() += mesh.points.row(1) - points.row(1);
            EXPECT_LT((points - mesh.points).cwiseAbs().maxCoeff(), 1e-10);

            EdgeLaplacian::Memory memory;
            laplacian.positions(layout, frames, laplacian.single_precision(), memory, points);
            points.rowwise() += mesh.points.row(1) - points.row(1);
            EXPECT_LT((points - mesh.points).cwiseAbs().maxCoeff(), 1e-4);
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
        const Rotations wanted = frames_of(target);
        const FaceLayout layout = layout_of(mesh);
        // From frames that are near, and from such that are not.
        for (const Rotations& from :
             {frames_of(mesh), wanted, Rotations(wanted.size(), wanted.front())}) {
            const Rotations fitted = fit_faces(mesh.topology, layout, weights, target.points, from);
            EXPECT_LT(largest_difference(fitted, wanted), 1e-10);
        }
    }
}

} // namespace
} // namespace shape
