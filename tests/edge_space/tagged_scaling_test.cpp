// SPDX-License-Identifier: MIT

#include "libshape/edge_space/tagged_scaling.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "libshape/base/error.h"
#include "libshape/base/to_size.h"
#include "libshape/edge_space/admissibility.h"
#include "tests/support/meshes.h"

namespace shape {
using namespace internal;
namespace {

using Eigen::VectorXd;

TEST(TaggedScaling, MultipliesInsideByTheFactorOutsideByOneAndHalfwayBetween)
{
    const Topology topology = test::icosphere(1).topology;
    const std::vector<int> tagged{3, 4, 11, 3};
    const VectorXd shares = tagged_shares(topology, tagged);
    const VectorXd ones = VectorXd::Ones(topology.edge_count());
    const ShapePoint scaled = scale_tagged({2.0 * ones, 0.1 * ones}, shares, 3.0);
    const auto is_tagged = [&](int v) {
        return std::find(tagged.begin(), tagged.end(), v) != tagged.end();
    };
    for (int e = 0; e < topology.edge_count(); ++e) {
        const int ends = is_tagged(topology.edges()(e, 0)) + is_tagged(topology.edges()(e, 1));
        EXPECT_EQ(scaled.edge_lengths[e], 2.0 * (1.0 + ends)); // 1, 2 or 3 times
    }
    EXPECT_EQ(scaled.dihedral_angles, 0.1 * ones);
}

TEST(TaggedScaling, BreaksNoEquilateralTriangle)
{
    const Topology topology = test::icosphere(2).topology;
    const std::vector<int> faces{0, 5, 17, 40};
    const VectorXd shares = tagged_shares(topology, corners_of_faces(topology, faces));
    const VectorXd faded = tagged_shares(topology, corners_of_faces(topology, faces), 2);
    const VectorXd ones = VectorXd::Ones(topology.edge_count());
    for (const double factor : {0.01, 0.5, 2.0, 100.0})
        for (const VectorXd& part : {shares, faded})
            EXPECT_TRUE(
                check_admissibility(topology, scale_tagged({ones, ones}, part, factor).edge_lengths)
                    .triangles.empty())
                << factor;
}

TEST(TaggedScaling, FadesOverTheRingsOfTheBorder)
{
    // On a path of edges along the patch the shares of vertices fall by a third an edge.
    const Topology topology = test::open_patch(9, 1).topology;
    const std::vector<int> tagged{0};
    Eigen::VectorXi distance = Eigen::VectorXi::Constant(topology.vertex_count(), 99);
    distance[0] = 0;
    for (int pass = 0; pass < topology.vertex_count(); ++pass)
        for (const auto& edge : topology.edges().rowwise())
            for (int end = 0; end < 2; ++end)
                distance[edge[end]] = std::min(distance[edge[end]], distance[edge[1 - end]] + 1);
    const VectorXd shares = tagged_shares(topology, tagged, 3);
    for (int e = 0; e < topology.edge_count(); ++e) {
        const auto share = [&](int v) { return std::max(0.0, 1.0 - distance[v] / 3.0); };
        EXPECT_NEAR(shares[e],
                    0.5 * (share(topology.edges()(e, 0)) + share(topology.edges()(e, 1))), 1e-15);
    }
    EXPECT_EQ(tagged_shares(topology, tagged, 1), tagged_shares(topology, tagged));
}

TEST(TaggedScaling, OfAllVerticesScalesTheMesh)
{
    const test::TestMesh mesh = test::open_patch(4, 1);
    std::vector<int> all(to_size(mesh.topology.face_count()));
    for (std::size_t i = 0; i < all.size(); ++i)
        all[i] = static_cast<int>(i);
    const VectorXd shares = tagged_shares(mesh.topology, corners_of_faces(mesh.topology, all));
    EXPECT_EQ(shares, VectorXd::Ones(mesh.topology.edge_count()));
}

TEST(TaggedScaling, RefusesWhatIsOutOfRange)
{
    const Topology topology = test::tetrahedron().topology;
    const VectorXd ones = VectorXd::Ones(6);
    EXPECT_THROW((void)tagged_shares(topology, std::vector{4}), InvalidInput);
    EXPECT_THROW((void)tagged_shares(topology, std::vector{-1}), InvalidInput);
    EXPECT_THROW((void)tagged_shares(topology, std::vector{0}, 0), InvalidInput);
    EXPECT_THROW((void)corners_of_faces(topology, std::vector{4}), InvalidInput);
    EXPECT_THROW((void)scale_tagged({ones, ones}, VectorXd::Ones(5), 2.0), InvalidInput);
    for (const double factor : {0.0, -1.0, static_cast<double>(NAN), 1.0 / 0.0})
        EXPECT_THROW((void)scale_tagged({ones, ones}, ones, factor), InvalidInput) << factor;
}

} // namespace
} // namespace shape
