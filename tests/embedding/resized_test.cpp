// SPDX-License-Identifier: MIT

#include "libshape/embedding/resized.h"

#include <gtest/gtest.h>

#include <variant>

#include "libshape/base/error.h"
#include "libshape/mesh/edge_lengths.h"
#include "tests/support/meshes.h"

namespace shape {
namespace {

/// Lengths that no mesh has: every third edge of a sphere is far too long.
ShapePoint infeasible_point(const test::TestMesh& mesh)
{
    ShapePoint point = test::shape_of(mesh.topology, mesh.points);
    for (Eigen::Index e = 0; e < point.edge_lengths.size(); e += 3)
        point.edge_lengths[e] *= 2.5;
    return point;
}

TEST(Resized, ShapesHaveLengthsAndPositionsTimesTheFactor)
{
    const test::TestMesh mesh = test::icosphere(1);
    ShapePoint point = test::shape_of(mesh.topology, mesh.points);
    point.positions = mesh.points;
    const auto larger = std::get<ShapePoint>(resized(DecodedShape(point), 3.0));
    EXPECT_EQ(larger.edge_lengths, 3.0 * point.edge_lengths);
    EXPECT_EQ(larger.positions, 3.0 * point.positions);
    EXPECT_EQ(larger.dihedral_angles, point.dihedral_angles);
    EXPECT_EQ(std::get<Points>(resized(DecodedShape(mesh.points), 3.0)), 3.0 * mesh.points);
}

TEST(Resized, MeshesKeepWhatTheyAreWorth)
{
    const test::TestMesh mesh = test::bumpy_sphere(2, 0.4, 1);
    const DecodedShape shape = infeasible_point(mesh);
    const Embedding own = Embedder(mesh.topology, {mesh.points}).embed(shape);
    ASSERT_EQ(own.report.status, EmbeddingStatus::Infeasible);
    const Embedding same = resized(own, mesh.topology, shape, 1.0);
    EXPECT_EQ(same.points, own.points);
    EXPECT_EQ(same.report.reason, own.report.reason);
    const Embedding larger = resized(own, mesh.topology, shape, 7.3);
    EXPECT_EQ(larger.points, 7.3 * own.points);
    EXPECT_EQ(larger.report.edge_rms, own.report.edge_rms);
    // The sides that the reason names are those of the larger target.
    EXPECT_EQ(larger.report.reason,
              Embedder(mesh.topology, {mesh.points}).embed(resized(shape, 7.3)).report.reason);
    EXPECT_NE(larger.report.reason, own.report.reason);
}

TEST(Resized, RefusesFactorsAndSizesThatNoMeshHas)
{
    const test::TestMesh mesh = test::icosphere(1);
    const DecodedShape shape = test::shape_of(mesh.topology, mesh.points);
    const Embedding own = Embedder(mesh.topology, {mesh.points}).embed(shape);
    for (const double factor : {0.0, -1.0, 1.0 / 0.0, 0.0 / 0.0}) {
        EXPECT_THROW((void)resized(shape, factor), InvalidInput) << factor;
        EXPECT_THROW((void)resized(own, mesh.topology, shape, factor), InvalidInput) << factor;
    }
    for (const double factor : {1e61, 1e-61}) {
        EXPECT_THROW((void)resized(own, mesh.topology, shape, factor), InvalidInput) << factor;
    }
}

} // namespace
} // namespace shape
