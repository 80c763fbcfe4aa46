// SPDX-License-Identifier: MIT

#include "libshape/embedding/residual_field.h"

#include <gtest/gtest.h>

#include <numbers>

#include "libshape/base/error.h"
#include "libshape/base/random.h"
#include "libshape/embedding/report.h"
#include "libshape/mesh/dihedral_angles.h"
#include "libshape/mesh/edge_lengths.h"
#include "tests/support/files.h"
#include "tests/support/meshes.h"

namespace shape {
using namespace internal;
namespace {

using test::TestMesh;

ShapePoint forms(const TestMesh& mesh)
{
    return {edge_lengths(mesh.topology, mesh.points), dihedral_angles(mesh.topology, mesh.points)};
}

TEST(ResidualField, VanishesForTheLengthsAndAnglesOfTheMeshInAnyPose)
{
    for (const TestMesh& mesh : test::sample_meshes()) {
        const ResidualField field =
            residual_field(mesh.topology, test::moved(mesh.points, 3), forms(mesh));
        EXPECT_LE(field.edge_error.maxCoeff(), 1e-12) << mesh.name;
        EXPECT_LE(field.dihedral_drift.maxCoeff(), 1e-9) << mesh.name;
    }
}

TEST(ResidualField, OfOneChangedEdgeIsSeenAtItsEndsAlone)
{
    for (const TestMesh& mesh : test::sample_meshes())
        for (int e = 0; e < mesh.topology.edge_count(); e += 7) {
            ShapePoint target = forms(mesh);
            target.edge_lengths[e] *= 1.25;    // the mesh has 4/5 of it
            target.dihedral_angles[e] += 0.25; // [rad]
            const double drift =
                mesh.topology.is_boundary_edge(e) ? 0.0 : 0.25 * 180.0 / std::numbers::pi;
            const ResidualField field = residual_field(mesh.topology, mesh.points, target);
            for (int v = 0; v < mesh.topology.vertex_count(); ++v) {
                const bool is_end = (mesh.topology.edges().row(e).array() == v).any();
                EXPECT_NEAR(field.edge_error[v], is_end ? 0.2 : 0.0, 1e-12);
                EXPECT_NEAR(field.dihedral_drift[v], is_end ? drift : 0.0, 1e-9);
            }
        }
}

TEST(ResidualField, HasTheLargestValuesOfTheReport)
{
    Random random(5);
    for (const TestMesh& mesh : test::sample_meshes()) {
        ShapePoint target = forms(mesh);
        for (int e = 0; e < mesh.topology.edge_count(); ++e) {
            target.edge_lengths[e] *= random.uniform(0.7, 1.3);
            target.dihedral_angles[e] += random.uniform(-4.0, 4.0);
        }
        const EmbeddingReport report = measure_embedding(mesh.topology, mesh.points, target);
        const ResidualField field = residual_field(mesh.topology, mesh.points, target);
        EXPECT_EQ(field.edge_error.maxCoeff(), report.edge_max) << mesh.name;
        EXPECT_EQ(field.dihedral_drift.maxCoeff(), report.dihedral_max_deg) << mesh.name;
    }
}

TEST(ResidualField, CountsNoFullTurns)
{
    const TestMesh mesh = test::icosphere(1);
    ShapePoint target = forms(mesh);
    target.dihedral_angles.array() += 4.0 * std::numbers::pi;
    EXPECT_LE(residual_field(mesh.topology, mesh.points, target).dihedral_drift.maxCoeff(), 1e-9);
}

TEST(ResidualField, RefusesWhatDoesNotFitTheTopology)
{
    const TestMesh mesh = test::tetrahedron();
    const ShapePoint good = forms(mesh);
    const auto message = [&](const Points& points, const ShapePoint& target) {
        return test::message_of<InvalidInput>(
            [&] { (void)residual_field(mesh.topology, points, target); });
    };
    EXPECT_NE(message(mesh.points, {good.edge_lengths.head(3), good.dihedral_angles})
                  .find("target has 3 lengths"),
              std::string::npos);
    EXPECT_NE(message(mesh.points, {good.edge_lengths, good.dihedral_angles.head(2)})
                  .find("2 dihedral angles"),
              std::string::npos);
    EXPECT_NE(message(Points::Zero(3, 3), good), "");
}

} // namespace
} // namespace shape
