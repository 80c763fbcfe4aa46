// SPDX-License-Identifier: MIT

#include "libshape/registration/synthetic_scan.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "libshape/base/error.h"
#include "libshape/mesh/edge_lengths.h"
#include "libshape/registration/closest_points.h"
#include "libshape/registration/rims.h"
#include "tests/support/meshes.h"

namespace shape::test {
using namespace internal;
namespace {

double farthest(const Points& points, const TestMesh& mesh)
{
    const ClosestPoints tree(mesh.points, mesh.topology.faces());
    double distance = 0.0;
    for (const auto& point : points.rowwise())
        distance = std::max(distance, tree.nearest(point.transpose()).distance);
    return distance;
}

TEST(SyntheticScan, IsAnotherTriangulationOfTheSurface)
{
    for (const TestMesh& mesh : {bumpy_sphere(3, 0.3, 5), open_cylinder(20, 12)})
        for (const int wanted : {300, 2000}) {
            const Scan scan = synthetic_scan(mesh.topology, mesh.points, {.vertices = wanted});
            EXPECT_NEAR(static_cast<double>(scan.points.rows()), wanted, 0.2 * wanted) << mesh.name;
            EXPECT_LT(farthest(scan.points, mesh), 0.02 * bounding_box_diagonal(mesh.points));
            // A manifold of the same genus and boundary, of even edges.
            const Topology topology(scan.faces, static_cast<int>(scan.points.rows()));
            const auto euler = [](const Topology& t) {
                return t.vertex_count() - t.edge_count() + t.face_count();
            };
            EXPECT_EQ(euler(topology), euler(mesh.topology));
            EXPECT_EQ(find_rims(scan.faces).loop_count,
                      find_rims(mesh.topology.faces()).loop_count);
            const Eigen::VectorXd lengths = edge_lengths(topology, scan.points);
            const double mean = lengths.mean();
            EXPECT_LT(std::sqrt((lengths.array() - mean).square().mean()), 0.3 * mean);
        }
}

TEST(SyntheticScan, HasNoiseHolesAndACut)
{
    const TestMesh mesh = bumpy_sphere(3, 0.2, 2);
    const SyntheticScanOptions clean{.vertices = 1500, .seed = 3};
    const Scan base = synthetic_scan(mesh.topology, mesh.points, clean);
    SyntheticScanOptions options = clean;
    options.noise = 0.2;
    const Scan noisy = synthetic_scan(mesh.topology, mesh.points, options);
    ASSERT_EQ(noisy.faces, base.faces);
    const double edge =
        (base.points(base.faces.col(0), Eigen::all) - base.points(base.faces.col(1), Eigen::all))
            .rowwise()
            .norm()
            .mean();
    const double moved = std::sqrt((noisy.points - base.points).rowwise().squaredNorm().mean());
    EXPECT_NEAR(moved, 0.2 * edge, 0.02 * edge);
    options = clean;
    options.holes = 3;
    options.hole_radius = 0.05;
    const Scan holed = synthetic_scan(mesh.topology, mesh.points, options);
    EXPECT_EQ(find_rims(base.faces).loop_count, 0);
    EXPECT_EQ(find_rims(holed.faces).loop_count, 3);
    options = clean;
    options.cut = 0.3;
    const Scan part = synthetic_scan(mesh.topology, mesh.points, options);
    EXPECT_NEAR(static_cast<double>(part.points.rows()),
                0.7 * static_cast<double>(base.points.rows()),
                0.02 * static_cast<double>(base.points.rows()));
}

TEST(SyntheticScan, DependsOnItsSeedAlone)
{
    const TestMesh mesh = bumpy_sphere(2, 0.2, 2);
    const SyntheticScanOptions one{.vertices = 400, .noise = 0.1, .holes = 1, .seed = 1};
    SyntheticScanOptions two = one;
    two.seed = 2;
    const Scan scan = synthetic_scan(mesh.topology, mesh.points, one);
    EXPECT_EQ(scan.points, synthetic_scan(mesh.topology, mesh.points, one).points);
    const Points other = synthetic_scan(mesh.topology, mesh.points, two).points;
    EXPECT_TRUE(other.rows() != scan.points.rows() || other != scan.points);
}

TEST(SyntheticScan, RefusesOptionsOutOfRange)
{
    EXPECT_THROW(check(SyntheticScanOptions{.vertices = 3}), InvalidInput);
    EXPECT_THROW(check(SyntheticScanOptions{.noise = -1.0}), InvalidInput);
    EXPECT_THROW(check(SyntheticScanOptions{.holes = -1}), InvalidInput);
    EXPECT_THROW(check(SyntheticScanOptions{.hole_radius = 0.0}), InvalidInput);
    EXPECT_THROW(check(SyntheticScanOptions{.cut = 1.0}), InvalidInput);
    const TestMesh mesh = tetrahedron();
    EXPECT_THROW((void)synthetic_scan(mesh.topology, mesh.points, {.cut = 1.0}), InvalidInput);
    EXPECT_THROW((void)spread_vertices(mesh.topology, mesh.points, 0), InvalidInput);
    EXPECT_THROW((void)spread_vertices(mesh.topology, mesh.points, 5), InvalidInput);
}

TEST(SpreadVertices, LieFarFromEachOtherAndFromTheBoundary)
{
    const TestMesh patch = open_patch(20, 1);
    for (const int v : spread_vertices(patch.topology, patch.points, 4))
        EXPECT_FALSE(patch.topology.is_boundary_vertex(v));
    const TestMesh ball = icosphere(3);
    const std::vector<int> four = spread_vertices(ball.topology, ball.points, 4);
    for (std::size_t i = 0; i < four.size(); ++i)
        for (std::size_t k = 0; k < i; ++k) // a regular tetrahedron's corners are 1.63 apart
            EXPECT_GT((ball.points.row(four[i]) - ball.points.row(four[k])).norm(), 1.2);
}

} // namespace
} // namespace shape::test
