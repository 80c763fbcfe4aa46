// SPDX-License-Identifier: MIT

#include "libshape/edge_space/admissibility.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <vector>

#include "libshape/base/error.h"
#include "libshape/base/random.h"
#include "libshape/mesh/edge_lengths.h"
#include "tests/support/meshes.h"

namespace shape {
using namespace internal;
namespace {

Eigen::VectorXd lengths_of(const test::TestMesh& mesh)
{
    return edge_lengths(mesh.topology, mesh.points);
}

/// A pyramid without its base: apex 0 is interior, with three equal faces around it.
Topology open_pyramid()
{
    Faces faces(3, 3);
    faces << 0, 1, 2, 0, 2, 3, 0, 3, 1;
    return {faces, 4};
}

TEST(CheckAdmissibility, FindsNothingInTheLengthsOfMeshes)
{
    for (const test::TestMesh& mesh : test::sample_meshes()) {
        const Admissibility result = check_admissibility(mesh.topology, lengths_of(mesh));
        EXPECT_TRUE(result.admissible()) << mesh.name;
        EXPECT_EQ(describe(result, mesh.topology, lengths_of(mesh)), "");
    }
}

TEST(CheckAdmissibility, KeepsTheTriangleInequalityStrict)
{
    const Topology topology = test::tetrahedron().topology;
    Eigen::VectorXd lengths = Eigen::VectorXd::Constant(6, 1.0);
    lengths[0] = 2.0 - 1e-15;
    EXPECT_TRUE(check_admissibility(topology, lengths).triangles.empty());
    lengths[0] = 2.0;
    const Admissibility flat = check_admissibility(topology, lengths);
    ASSERT_EQ(flat.triangles.size(), 2u);
    EXPECT_EQ(flat.triangles[0].excess, 0.0);
    lengths[0] = 3.0;
    EXPECT_DOUBLE_EQ(check_admissibility(topology, lengths).triangles[0].excess, 0.5);
}

TEST(CheckAdmissibility, TakesLengthsThatAreNotPositiveForBrokenTriangles)
{
    const Topology topology = test::tetrahedron().topology;
    for (const double length : {0.0, -1.0, -3.0}) {
        Eigen::VectorXd lengths = Eigen::VectorXd::Ones(6);
        lengths[2] = length;
        EXPECT_EQ(check_admissibility(topology, lengths).triangles.size(), 2u) << length;
    }
    EXPECT_EQ(check_admissibility(topology, -Eigen::VectorXd::Ones(6)).triangles.at(0).excess,
              std::numeric_limits<double>::infinity());
}

TEST(CheckAdmissibility, ListsTheWorstTriangleFirst)
{
    const test::TestMesh mesh = test::icosphere(1);
    Eigen::VectorXd lengths = lengths_of(mesh);
    lengths[3] *= 2.5;
    lengths[60] *= 4.0;
    const Admissibility result = check_admissibility(mesh.topology, lengths);
    ASSERT_EQ(result.triangles.size(), 4u);
    for (std::size_t i = 1; i < 4; ++i)
        EXPECT_GE(result.triangles[i - 1].excess, result.triangles[i].excess);
    const int worst = result.triangles[0].face;
    EXPECT_TRUE((mesh.topology.face_edges().row(worst).array() == 60).any());
}

TEST(CheckAdmissibility, FindsAVertexWhoseAnglesCloseToNoSphericalPolygon)
{
    // Base edges 1-2, 1-3, 2-3 below legs of length 1: an angle is 2 asin(base / 2).
    const Topology topology = open_pyramid();
    const auto with_bases = [&](double a, double b, double c) {
        Eigen::VectorXd lengths = Eigen::VectorXd::Ones(6);
        lengths[topology.find_edge(1, 2)] = 2.0 * std::sin(a / 2.0);
        lengths[topology.find_edge(2, 3)] = 2.0 * std::sin(b / 2.0);
        lengths[topology.find_edge(3, 1)] = 2.0 * std::sin(c / 2.0);
        return lengths;
    };
    const Admissibility result = check_admissibility(topology, with_bases(1.5, 0.8, 0.6));
    EXPECT_TRUE(result.triangles.empty());
    ASSERT_EQ(result.vertices.size(), 1u);
    EXPECT_EQ(result.vertices[0].vertex, 0);
    EXPECT_NEAR(result.vertices[0].excess, 0.1, 1e-14);
    EXPECT_TRUE(check_admissibility(topology, with_bases(1.5, 0.8, 0.75)).admissible());
    // Equality is a fan folded flat: a mesh has it.
    EXPECT_TRUE(check_admissibility(topology, with_bases(1.5, 0.8, 0.7)).admissible());
    // The sum may pass 2 pi.
    EXPECT_TRUE(check_admissibility(topology, with_bases(2.5, 2.5, 2.5)).admissible());
}

TEST(CheckAdmissibility, FindsWhatTheAnglesOfAllVerticesShow)
{
    Random random(3);
    std::size_t found = 0;
    for (const test::TestMesh& mesh : test::sample_meshes())
        for (int trial = 0; trial < 200; ++trial) {
            const Topology& t = mesh.topology;
            Eigen::VectorXd lengths = lengths_of(mesh);
            for (double& length : lengths)
                length *= std::exp(random.uniform(-0.6, 0.6) * random.uniform());
            const Admissibility result = check_admissibility(t, lengths);
            std::vector<char> broken(static_cast<std::size_t>(t.vertex_count()), 0);
            for (const TriangleViolation& triangle : result.triangles)
                for (const int v : t.faces().row(triangle.face))
                    broken[static_cast<std::size_t>(v)] = 1;
            const Points angles = corner_angles(t, lengths);
            std::map<int, double> expected;
            for (int v = 0; v < t.vertex_count(); ++v) {
                double largest = 0.0, sum = 0.0;
                for (const int h : t.outgoing(v)) {
                    largest = std::max(largest, angles(h / 3, h % 3));
                    sum += angles(h / 3, h % 3);
                }
                if (!t.is_boundary_vertex(v) && broken[static_cast<std::size_t>(v)] == 0 &&
                    2.0 * largest - sum > 1e-12)
                    expected[v] = largest - (sum - largest);
            }
            ASSERT_EQ(result.vertices.size(), expected.size());
            for (const VertexViolation& vertex : result.vertices)
                EXPECT_EQ(vertex.excess, expected.at(vertex.vertex));
            found += expected.size();
        }
    EXPECT_GT(found, 100U);
}

TEST(CheckAdmissibility, LeavesOutVerticesOfBrokenTriangles)
{
    const Topology topology = open_pyramid();
    Eigen::VectorXd lengths = Eigen::VectorXd::Constant(6, 1.0);
    lengths[topology.find_edge(1, 2)] = 2.5;
    lengths[topology.find_edge(2, 3)] = 0.1;
    lengths[topology.find_edge(3, 1)] = 0.1;
    const Admissibility result = check_admissibility(topology, lengths);
    EXPECT_EQ(result.triangles.size(), 1u);
    EXPECT_TRUE(result.vertices.empty());
}

TEST(CheckAdmissibility, RefusesOtherSizesAndWhatIsNotFinite)
{
    const Topology topology = test::tetrahedron().topology;
    Eigen::VectorXd lengths = Eigen::VectorXd::Ones(6);
    EXPECT_THROW((void)check_admissibility(topology, lengths.head(5)), InvalidInput);
    lengths[4] = std::numeric_limits<double>::quiet_NaN();
    EXPECT_THROW((void)check_admissibility(topology, lengths), InvalidInput);
}

TEST(DescribeAdmissibility, NamesTheWorstFaceAndTheWorstVertex)
{
    const Topology topology = test::tetrahedron().topology;
    Eigen::VectorXd lengths = Eigen::VectorXd::Ones(6);
    lengths[0] = 3.0;
    const std::string triangles =
        describe(check_admissibility(topology, lengths), topology, lengths);
    EXPECT_NE(triangles.find("2 of 4 faces break the triangle inequality, worst face 0"),
              std::string::npos)
        << triangles;

    const Admissibility vertex{{}, {{2, 0.25}}};
    EXPECT_EQ(describe(vertex, topology, lengths),
              "1 of 4 vertices have a face angle larger than the sum of their others, worst vertex "
              "2 by 0.25 rad");
}

TEST(FeasibleStep, EndsWhereTheFirstTriangleBreaks)
{
    for (const test::TestMesh& mesh : test::sample_meshes())
        for (unsigned seed = 1; seed <= 20; ++seed) {
            SCOPED_TRACE(mesh.name);
            const Eigen::VectorXd lengths = lengths_of(mesh);
            Random random(seed);
            Eigen::VectorXd direction(lengths.size());
            for (double& entry : direction)
                entry = random.normal();
            const double step = feasible_step(mesh.topology, lengths, direction, 1e6);
            const auto breaks = [&](double t) {
                return !check_admissibility(mesh.topology, lengths + t * direction)
                            .triangles.empty();
            };
            EXPECT_GT(step, 0.0);
            EXPECT_FALSE(breaks(0.5 * step));
            EXPECT_FALSE(breaks(step * (1.0 - 1e-9)));
            EXPECT_TRUE(breaks(step * (1.0 + 1e-9)));
        }
}

TEST(FeasibleStep, IsTheLimitWhereNothingBreaks)
{
    const test::TestMesh mesh = test::icosphere(1);
    const Eigen::VectorXd lengths = lengths_of(mesh);
    EXPECT_EQ(feasible_step(mesh.topology, lengths, lengths, 5.0), 5.0);
    EXPECT_EQ(feasible_step(mesh.topology, lengths, 0.0 * lengths, 5.0), 5.0);
    EXPECT_NEAR(feasible_step(mesh.topology, lengths, -lengths, 5.0), 1.0, 1e-12);
}

TEST(FeasibleStep, IsZeroFromABrokenTriangle)
{
    const Topology topology = test::tetrahedron().topology;
    Eigen::VectorXd lengths = Eigen::VectorXd::Ones(6);
    lengths[1] = 2.0;
    EXPECT_EQ(feasible_step(topology, lengths, Eigen::VectorXd::Ones(6), 1.0), 0.0);
}

TEST(PositiveLengths, RaisesOnlyThoseThatAreNotOrAreNothing)
{
    const Eigen::VectorXd lengths{{1.0, 0.0, 3.0, -2.0, 1e-8, 4.0}};
    const double raised = 1e-2 * lengths.mean();
    const Eigen::VectorXd expected{{1.0, raised, 3.0, raised, 1e-8, 4.0}};
    EXPECT_EQ(positive_lengths(lengths), expected);
    EXPECT_EQ(positive_lengths(expected), expected);
    EXPECT_EQ(positive_lengths(Eigen::Vector3d(1.0, 1e-300, 2.0)),
              Eigen::Vector3d(1.0, 1e-9 * (3.0 + 1e-300) / 3.0, 2.0));
}

TEST(PositiveLengths, RefusesAMeanOfZeroAndValuesThatAreNotFinite)
{
    EXPECT_THROW((void)positive_lengths(Eigen::Vector3d(1.0, -2.0, 1.0)), InvalidInput);
    EXPECT_THROW((void)positive_lengths(Eigen::Vector3d(1.0, std::nan(""), 1.0)), InvalidInput);
}

TEST(FeasibleStep, RefusesOtherSizes)
{
    const Topology topology = test::tetrahedron().topology;
    const Eigen::VectorXd lengths = Eigen::VectorXd::Ones(6);
    EXPECT_THROW((void)feasible_step(topology, lengths.head(5), lengths, 1.0), InvalidInput);
    EXPECT_THROW((void)feasible_step(topology, lengths, lengths.head(5), 1.0), InvalidInput);
}

} // namespace
} // namespace shape
