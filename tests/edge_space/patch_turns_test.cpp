// SPDX-License-Identifier: MIT

#include "libshape/edge_space/patch_turns.h"

#include <gtest/gtest.h>

#include <numbers>

#include "libshape/base/error.h"
#include "libshape/base/random.h"
#include "libshape/base/to_size.h"
#include "libshape/edge_space/shape_vectors.h"
#include "tests/support/meshes.h"

namespace shape {
namespace {

using namespace internal;
using Eigen::Vector3d;
using Eigen::VectorXd;

/// Points of a sphere, pushed about smoothly and without symmetry.
Points bent(const Points& points)
{
    Points result = points;
    for (auto row : result.rowwise()) {
        const double turn = 0.9 * row.z() + 0.2 * row.x();
        const double x = std::cos(turn) * row.x() - std::sin(turn) * row.y();
        const double y = std::sin(turn) * row.x() + std::cos(turn) * row.y();
        row << x, y + 0.3 * x * x, 1.2 * row.z() + 0.2 * x * y;
    }
    return result;
}

Points mirrored(Points points)
{
    points.col(0) *= -1.0;
    return points;
}

TEST(RotationVectors, AreInverseToRotationsBothWays)
{
    Random random(2);
    for (int i = 0; i < 200; ++i) {
        Vector3d vector(random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0),
                        random.uniform(-1.0, 1.0));
        vector *= random.uniform(0.0, std::numbers::pi) / vector.norm();
        const Eigen::Quaterniond rotation = rotation_by(vector);
        EXPECT_LT((rotation_vector(rotation) - vector).norm(), 1e-12);
        // The same rotation has two quaternions; and a whole turn more is none.
        EXPECT_LT((rotation_vector(Eigen::Quaterniond(-rotation.coeffs())) - vector).norm(), 1e-12);
        const Vector3d longer = vector + 2.0 * std::numbers::pi * vector.normalized();
        EXPECT_LT((rotation_vector(rotation_by(longer)) - vector).norm(), 1e-9);
    }
    EXPECT_EQ(rotation_vector(rotation_by(Vector3d::Zero())), Vector3d::Zero());
}

TEST(FaceFrames, LieAsTheFacesDo)
{
    const test::TestMesh mesh = test::torus(12, 20);
    const Rotations frames = face_frames(mesh.topology, mesh.points);
    for (int f = 0; f < mesh.topology.face_count(); ++f) {
        const auto corner = [&](int c) -> Vector3d {
            return mesh.points.row(mesh.topology.faces()(f, c));
        };
        const Eigen::Matrix3d frame = frames[to_size(f)].toRotationMatrix();
        const Vector3d normal = (corner(1) - corner(0)).cross(corner(2) - corner(0));
        EXPECT_LT((frame.col(0) - (corner(1) - corner(0)).normalized()).norm(), 1e-12);
        EXPECT_LT((frame.col(2) - normal.normalized()).norm(), 1e-12);
    }
}

TEST(PatchTurns, OfTheReferenceAreZeroAndNoRigidMotionChangesThem)
{
    for (const test::TestMesh& mesh : test::sample_meshes()) {
        SCOPED_TRACE(mesh.name);
        const PatchTurns turns(mesh.topology, mesh.points);
        EXPECT_EQ(turns.of(mesh.points).size(), turns.size());
        EXPECT_LT(turns.of(test::moved(mesh.points, 3)).cwiseAbs().sum(), 1e-9);
        const Points other = bent(mesh.points);
        const VectorXd found = turns.of(other);
        EXPECT_LT((turns.of(test::moved(other, 5)) - found).cwiseAbs().sum(), 1e-9);
        // Nor does one of the reference: the turns are seen from its patches.
        const VectorXd seen = PatchTurns(mesh.topology, 1024.0 * mesh.points).of(other);
        EXPECT_LT((seen - found).cwiseAbs().sum(), 1e-9);
    }
}

TEST(PatchTurns, AreSmallWhereTheyAddUpToSeveralTimesAround)
{
    // A twisted cylinder: every cross-section is turned by an angle that grows along the axis.
    const test::TestMesh mesh = test::open_cylinder(12, 160);
    const double length = mesh.points.col(2).maxCoeff() - mesh.points.col(2).minCoeff();
    const double turn = 6.0 * std::numbers::pi / length;
    Points wound = mesh.points;
    for (auto row : wound.rowwise()) {
        const Eigen::AngleAxisd about(turn * row.z(), Vector3d::UnitZ());
        row = (about * Vector3d(row.transpose())).transpose().eval();
    }
    const VectorXd turns = PatchTurns(mesh.topology, mesh.points).of(wound);
    ASSERT_GT(turns.size(), 0);
    double largest = 0.0;
    for (Eigen::Index k = 0; k < turns.size(); k += 3)
        largest = std::max(largest, turns.segment<3>(k).norm());
    EXPECT_GT(largest, 0.1);
    EXPECT_LT(largest, std::numbers::pi);
}

TEST(PatchTurns, OfTheMirrorImageAreMirrored)
{
    const test::TestMesh mesh = test::icosphere(3);
    const Points other = bent(mesh.points);
    const VectorXd turns = PatchTurns(mesh.topology, mesh.points).of(other);
    const VectorXd images = PatchTurns(mesh.topology, mirrored(mesh.points)).of(mirrored(other));
    for (Eigen::Index k = 0; k < turns.size(); k += 3) {
        const Vector3d expected(turns[k], -turns[k + 1], -turns[k + 2]); // an axis is not an arrow
        EXPECT_LT((images.segment<3>(k) - expected).norm(), 1e-9);
    }
}

TEST(PatchTurns, AreBlendedByTheSameWeights)
{
    const test::TestMesh mesh = test::icosphere(3);
    const Collection collection{mesh.topology, {"a", "b"}, {mesh.points, bent(mesh.points)}, {}};
    const ShapeVectors vectors = shape_vectors(collection, Scale::None);
    const ShapePoint point = blend(vectors, Eigen::Vector2d(0.25, 0.75));
    const VectorXd turns = PatchTurns(mesh.topology, mesh.points).of(collection.points[1]);
    EXPECT_LT((point.patch_turns - 0.75 * turns).norm(), 1e-12);
}

TEST(PatchTurns, RefuseAnotherNumberOfVertices)
{
    const test::TestMesh mesh = test::icosphere(2);
    EXPECT_THROW((void)PatchTurns(mesh.topology, mesh.points).of(mesh.points.topRows(5)),
                 InvalidInput);
}

} // namespace
} // namespace shape
