// SPDX-License-Identifier: MIT

#include "libshape/conformal/intrinsic_triangulation.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <cmath>
#include <limits>
#include <numbers>
#include <set>

#include "libshape/base/error.h"
#include "libshape/base/random.h"
#include "libshape/mesh/edge_lengths.h"
#include "tests/conformal/closed_meshes.h"

namespace shape {
using namespace internal;
namespace {

IntrinsicTriangulation triangulate(const test::TestMesh& mesh)
{
    return {mesh.topology, edge_lengths(mesh.topology, mesh.points)};
}

/// Every half-edge is the opposite of its opposite, runs back, and knows its edge.
void expect_consistent(const IntrinsicTriangulation& t)
{
    for (int h = 0; h < 3 * t.face_count(); ++h) {
        if (t.opposite(h) < 0)
            continue;
        EXPECT_EQ(t.opposite(t.opposite(h)), h);
        EXPECT_EQ(t.source(t.opposite(h)), t.target(h));
        EXPECT_EQ(t.edge(t.opposite(h)), t.edge(h));
        EXPECT_TRUE(t.halfedge(t.edge(h)) == h || t.halfedge(t.edge(h)) == t.opposite(h));
    }
}

TEST(IntrinsicTriangulation, StartsAsTheMesh)
{
    for (const test::TestMesh& mesh : test::sample_meshes()) {
        const IntrinsicTriangulation t = triangulate(mesh);
        for (int h = 0; h < mesh.topology.halfedge_count(); ++h) {
            EXPECT_EQ(t.source(h), mesh.topology.source(h));
            EXPECT_EQ(t.edge(h), mesh.topology.edge(h));
            EXPECT_EQ(t.opposite(h), mesh.topology.opposite(h));
        }
        for (int v = 0; v < t.vertex_count(); ++v) {
            const auto expected = mesh.topology.outgoing(v);
            for (const int start : expected) {
                const std::vector<int> ring = t.ring(start);
                EXPECT_EQ(std::set<int>(ring.begin(), ring.end()),
                          std::set<int>(expected.begin(), expected.end()));
                if (mesh.topology.is_boundary_vertex(v)) {
                    EXPECT_EQ(ring.front(), expected.front());
                }
            }
        }
    }
}

TEST(IntrinsicTriangulation, StaysConsistentUnderManyFlips)
{
    for (const test::TestMesh& mesh : test::sample_meshes()) {
        SCOPED_TRACE(mesh.name);
        IntrinsicTriangulation t = triangulate(mesh);
        Random random(5);
        int flips = 0;
        for (int i = 0; i < 2000; ++i) {
            const auto e =
                static_cast<int>(random.index(static_cast<std::uint64_t>(t.edge_count())));
            if (!t.is_flippable(e))
                continue;
            t.flip(e);
            ++flips;
        }
        EXPECT_GT(flips, 500);
        expect_consistent(t);
    }
}

TEST(IntrinsicTriangulation, AFlipThereAndBackRestoresTheLength)
{
    IntrinsicTriangulation t = triangulate(test::bumpy_sphere(2, 0.4, 3));
    const Eigen::VectorXd before = t.log_lengths();
    for (int e = 0; e < t.edge_count(); ++e) {
        const std::set<int> ends{t.source(t.halfedge(e)), t.target(t.halfedge(e))};
        t.flip(e);
        EXPECT_FALSE(ends.contains(t.source(t.halfedge(e))));
        t.flip(e);
        EXPECT_TRUE(ends.contains(t.source(t.halfedge(e))));
        EXPECT_NEAR(t.log_lengths()[e], before[e], 1e-14);
    }
}

TEST(IntrinsicTriangulation, FlippedLengthsOfPointsOnACircleAreDistances)
{
    // Ptolemy's theorem.
    Faces faces(2, 3);
    faces << 0, 1, 2, 0, 2, 3;
    const Topology topology(faces, 4);
    Random random(3);
    for (int i = 0; i < 100; ++i) {
        Points points(4, 3);
        for (int v = 0; v < 4; ++v) {
            const double angle = 0.5 * std::numbers::pi * (v + random.uniform(0.01, 0.99));
            points.row(v) << std::cos(angle), std::sin(angle), 0.0;
        }
        const IntrinsicTriangulation t(topology, edge_lengths(topology, points));
        EXPECT_NEAR(t.flipped_log_length(topology.find_edge(0, 2)),
                    std::log((points.row(1) - points.row(3)).norm()), 1e-14);
    }
}

TEST(IntrinsicTriangulation, RefusesLengthsThatAreNone)
{
    const test::TestMesh mesh = test::tetrahedron();
    EXPECT_THROW(IntrinsicTriangulation(mesh.topology, Eigen::VectorXd::Ones(5)), InvalidInput);
    for (const double bad : {0.0, -1.0, std::numeric_limits<double>::quiet_NaN(),
                             std::numeric_limits<double>::infinity()}) {
        Eigen::VectorXd lengths = Eigen::VectorXd::Ones(6);
        lengths[4] = bad;
        try {
            IntrinsicTriangulation t(mesh.topology, lengths);
            ADD_FAILURE() << "took " << bad;
        } catch (const InvalidInput& error) {
            EXPECT_NE(std::string(error.what()).find("lengths[4]"), std::string::npos);
        }
    }
}

} // namespace
} // namespace shape
