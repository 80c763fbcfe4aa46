// SPDX-License-Identifier: MIT

#include "libshape/conformal/disc_map.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "libshape/base/error.h"
#include "libshape/mesh/edge_lengths.h"
#include "tests/conformal/closed_meshes.h"

namespace shape {
namespace {

/// The patch pressed flat onto the plane.
test::TestMesh flat_patch()
{
    test::TestMesh mesh = test::open_patch(12, 3);
    mesh.points.col(2).setZero();
    return mesh;
}

void expect_exact(const DiscMap& map)
{
    EXPECT_EQ(map.certificate, ConformalCertificate::Exact);
    EXPECT_LE(map.edges.worst, 1e-12);
    EXPECT_LE(map.angle_residual, 1e-12);
    EXPECT_LE(map.newton_steps, 25);
}

TEST(DiscMap, LeavesAFlatDiscAsItIs)
{
    const test::TestMesh mesh = flat_patch();
    const DiscMap map = map_to_plane(mesh.topology, edge_lengths(mesh.topology, mesh.points));
    expect_exact(map);
    EXPECT_NEAR(map.factors.lpNorm<Eigen::Infinity>(), 0.0, 1e-13);
    for (int v = 0; v < mesh.topology.vertex_count(); ++v)
        EXPECT_NEAR(std::abs(map.layout.difference(0, v)),
                    (mesh.points.row(v) - mesh.points.row(0)).norm(), 1e-12);
}

TEST(DiscMap, UndoesAMoebiusTransformation)
{
    // The patch on a sphere: its factors to the plane are those of the stereographic projection.
    const test::TestMesh mesh = flat_patch();
    Points sphere(mesh.points.rows(), 3);
    DiscMapOptions options{Eigen::VectorXd(mesh.points.rows())};
    for (int v = 0; v < sphere.rows(); ++v) {
        const double x = mesh.points(v, 0);
        const double y = mesh.points(v, 1);
        const double denominator = 1.0 + x * x + y * y;
        sphere.row(v) << 2.0 * x / denominator, 2.0 * y / denominator,
            (2.0 - denominator) / denominator;
        options.boundary_factors[v] = std::log(denominator / 2.0);
    }
    const DiscMap map = map_to_plane(mesh.topology, edge_lengths(mesh.topology, sphere), options);
    expect_exact(map);
    EXPECT_NEAR((map.factors - options.boundary_factors).lpNorm<Eigen::Infinity>(), 0.0, 1e-12);
    for (int v = 0; v < mesh.topology.vertex_count(); ++v)
        EXPECT_NEAR(std::abs(map.layout.difference(0, v)),
                    (mesh.points.row(v) - mesh.points.row(0)).norm(), 1e-12);
}

TEST(DiscMap, KeepsTheBoundaryLengthsOfACurvedDisc)
{
    const test::TestMesh mesh = test::open_patch(20, 3);
    const Eigen::VectorXd lengths = edge_lengths(mesh.topology, mesh.points);
    const DiscMap map = map_to_plane(mesh.topology, lengths);
    expect_exact(map);
    EXPECT_GT(map.factors.lpNorm<Eigen::Infinity>(), 0.01);
    for (int e = 0; e < mesh.topology.edge_count(); ++e)
        if (mesh.topology.is_boundary_edge(e)) {
            EXPECT_NEAR(std::abs(map.layout.difference(mesh.topology.edges()(e, 0),
                                                       mesh.topology.edges()(e, 1))),
                        lengths[e], 1e-12);
        }
    // Every face is counter-clockwise.
    for (int f = 0; f < mesh.topology.face_count(); ++f) {
        const Eigen::RowVector3i v = mesh.topology.faces().row(f);
        EXPECT_GT((std::conj(map.layout.difference(v[0], v[1])) * map.layout.difference(v[0], v[2]))
                      .imag(),
                  0.0);
    }
}

TEST(DiscMap, TakesASingleTriangle)
{
    Faces face(1, 3);
    face << 0, 1, 2;
    const DiscMap map = map_to_plane(Topology(face, 3), Eigen::Vector3d(3.0, 4.0, 5.0));
    EXPECT_EQ(map.certificate, ConformalCertificate::Exact);
    EXPECT_NEAR(std::abs(map.layout.difference(1, 2)), 5.0, 1e-14);
}

TEST(DiscMap, FlipsEdgesWhereTheTriangulationHasNoSolution)
{
    const test::TestMesh mesh = test::with_slivers(test::open_patch(12, 3), 0.05, 0.1, 3);
    const DiscMap map = map_to_plane(mesh.topology, edge_lengths(mesh.topology, mesh.points));
    EXPECT_EQ(map.certificate, ConformalCertificate::Repaired);
    EXPECT_GT(map.edges.flipped.size(), 0u);
    EXPECT_LE(map.edges.worst, 1e-10);
}

TEST(DiscMap, SaysWhenAFaceBreaksAtTheBoundary)
{
    Faces face(1, 3);
    face << 0, 1, 2;
    const DiscMap map = map_to_plane(Topology(face, 3), Eigen::Vector3d(1.0, 1.0, 3.0));
    EXPECT_EQ(map.certificate, ConformalCertificate::Unsolved);
}

TEST(DiscMap, RefusesWhatIsNotADisc)
{
    for (const test::TestMesh& mesh :
         {test::icosphere(1), test::open_cylinder(6, 4), test::torus(9, 16)})
        EXPECT_THROW((void)map_to_plane(mesh.topology, edge_lengths(mesh.topology, mesh.points)),
                     InvalidInput);
    const test::TestMesh mesh = flat_patch();
    const Eigen::VectorXd lengths = edge_lengths(mesh.topology, mesh.points);
    EXPECT_THROW((void)map_to_plane(mesh.topology, Eigen::VectorXd::Ones(3)), InvalidInput);
    EXPECT_THROW((void)map_to_plane(mesh.topology, lengths, {Eigen::VectorXd::Zero(3)}),
                 InvalidInput);
    EXPECT_THROW(
        (void)map_to_plane(mesh.topology, lengths,
                           {Eigen::VectorXd::Constant(mesh.topology.vertex_count(),
                                                      std::numeric_limits<double>::infinity())}),
        InvalidInput);
}

} // namespace
} // namespace shape
