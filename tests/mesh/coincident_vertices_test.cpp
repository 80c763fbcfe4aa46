// SPDX-License-Identifier: MIT

#include "libshape/mesh/coincident_vertices.h"

#include <gtest/gtest.h>

#include <limits>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/to_size.h"
#include "tests/support/files.h"
#include "tests/support/seams.h"

namespace shape {
using namespace internal;
namespace {

using test::CutMesh;
using test::TestMesh;

TEST(CoincidentVertices, AreFoundWhereASurfaceWasCutAndWeldingClosesIt)
{
    for (const TestMesh& mesh : {test::icosphere(2), test::bumpy_sphere(3, 0.2, 4)}) {
        const CutMesh cut = test::cut_along_the_equator(mesh);
        ASSERT_GT(cut.doubled(mesh.points), 5);
        const Points points = cut.points(test::moved(mesh.points, 3));
        EXPECT_FALSE(Topology(cut.faces, static_cast<int>(points.rows())).is_closed());
        const std::vector<VertexGroup> groups = coincident_vertices(std::span(&points, 1));
        ASSERT_EQ(std::ssize(groups), cut.doubled(mesh.points));
        for (const VertexGroup& group : groups) {
            ASSERT_EQ(group.size(), 2U);
            EXPECT_LT(group[0], mesh.points.rows());
            EXPECT_EQ(cut.vertices[to_size(group[1])], group[0]);
        }
        const VertexChoice whole = weld(cut.faces, static_cast<int>(points.rows()), groups);
        EXPECT_EQ(whole.faces, mesh.topology.faces());
        EXPECT_EQ(chosen_points(points, whole.vertices), points.topRows(mesh.points.rows()));
    }
}

TEST(CoincidentVertices, AreThoseOfEveryMesh)
{
    const Points closed = (Points(4, 3) << 0, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0, 0).finished();
    Points half_open = closed;
    half_open(3, 1) = 0.5;
    using Groups = std::vector<VertexGroup>;
    EXPECT_EQ(coincident_vertices(std::vector{closed}), (Groups{{0, 2}, {1, 3}}));
    EXPECT_EQ(coincident_vertices(std::vector{closed, half_open}), (Groups{{0, 2}}));
    EXPECT_EQ(coincident_vertices(std::vector{half_open, closed}), (Groups{{0, 2}}));
    const Points elsewhere = (Points(4, 3) << 0, 0, 0, 0, 0, 0, 1, 0, 0, 1, 0, 0).finished();
    EXPECT_EQ(coincident_vertices(std::vector{closed, elsewhere}), Groups{});
    const Points one_place = Points::Ones(4, 3);
    EXPECT_EQ(coincident_vertices(std::vector{one_place}), (Groups{{0, 1, 2, 3}}));
    EXPECT_EQ(coincident_vertices(std::vector{one_place, half_open}), (Groups{{0, 2}}));
}

TEST(CoincidentVertices, AreNearerThanSinglePrecisionTells)
{
    // The diagonal of the box is 100.
    Points points = (Points(3, 3) << 0, 0, 0, 60, 80, 0, 0, 0, 0).finished();
    points(2, 2) = 0.9e-5;
    EXPECT_EQ(coincident_vertices(std::span(&points, 1)).size(), 1U);
    points(2, 2) = 1.1e-5;
    EXPECT_TRUE(coincident_vertices(std::span(&points, 1)).empty());
}

TEST(CoincidentVertices, JoinsAHeapByWayOfOthers)
{
    Points heap = Points::Ones(1000, 3);
    heap.row(0).setZero();
    const std::vector<VertexGroup> groups = coincident_vertices(std::span(&heap, 1));
    ASSERT_EQ(groups.size(), 1U);
    EXPECT_EQ(groups[0].size(), 999U);
    // The tolerance is 2; the second and the third are within it of the first, not of each other.
    Points three(4, 3);
    three << 0, 0, 0, 0, 1.9, 0, 1.9, 0, 0, 20, 0, 0;
    const double tolerance = 2.0 / bounding_box_diagonal(three);
    EXPECT_EQ(coincident_vertices(std::span(&three, 1), tolerance),
              (std::vector<VertexGroup>{{0, 1, 2}}));
}

/// Bumpy spheres in two patches, 20 across and 900 from the origin.
class SeamVerticesOfPatches : public testing::Test
{
protected:
    TestMesh mesh_ = test::bumpy_sphere(2, 0.1, 1);
    CutMesh cut_ = test::cut_along_the_equator(mesh_, true);
    int doubled_ = cut_.doubled(mesh_.points);

    [[nodiscard]] Points patches(unsigned seed) const
    {
        return 8.0 * cut_.points(test::bumpy_sphere(2, 0.1, seed).points);
    }
    [[nodiscard]] SeamVertices seams(const std::vector<Points>& meshes) const
    {
        return seam_vertices(cut_.faces, meshes);
    }
    [[nodiscard]] Points apart(Points points, double share) const
    {
        points.bottomRows(doubled_).col(0).array() += share * bounding_box_diagonal(points);
        return points;
    }
};

TEST_F(SeamVerticesOfPatches, LieOnOneAnotherWithinTheSpacingOfTheirNumbers)
{
    const Points single = test::in_scanner_coordinates(patches(1), doubled_);
    EXPECT_TRUE(coincident_vertices(std::span(&single, 1)).empty()); // 2e-6 of the diagonal
    const SeamVertices found = seams({single});
    EXPECT_EQ(std::ssize(found.coincident), doubled_);
    EXPECT_TRUE(found.near.empty());
    EXPECT_EQ(found.gap, 0.0);
    // The spacing of any of them is that of all.
    EXPECT_EQ(std::ssize(seams({apart(patches(2), 5e-6), single}).coincident), doubled_);
    // Full precision says that they are apart.
    EXPECT_TRUE(seams({apart(patches(2), 5e-6)}).coincident.empty());
    EXPECT_EQ(std::ssize(seams({apart(patches(2), 0.9e-7)}).coincident), doubled_);
}

TEST_F(SeamVerticesOfPatches, LieNearOneAnotherUpToAThousandthOfTheDiagonal)
{
    const SeamVertices near = seams({patches(1), apart(patches(2), 0.99e-3)});
    EXPECT_TRUE(near.coincident.empty());
    EXPECT_EQ(std::ssize(near.near), doubled_);
    EXPECT_NEAR(near.gap, 0.99e-3, 1e-5);
    EXPECT_TRUE(seams({patches(1), apart(patches(2), 1.01e-3)}).near.empty());
    // What is near in some meshes alone opens in others: lips.
    EXPECT_TRUE(seams({patches(1), apart(patches(2), 0.1)}).near.empty());
    Points half = patches(1);
    half.bottomRows(doubled_ / 2).col(0).array() += 1e-4 * bounding_box_diagonal(half);
    const SeamVertices both = seams({half});
    EXPECT_EQ(std::ssize(both.near), doubled_ / 2);
    EXPECT_EQ(std::ssize(both.coincident), doubled_ - doubled_ / 2);
}

TEST_F(SeamVerticesOfPatches, AreNotTheEndsOfShortEdgesNorInside)
{
    // A strip with an edge of its rim of 1e-5, which is the spacing of its numbers.
    Points points(5, 3);
    points << 0, 0, 0, 1, 0, 0, 1.00001, 0, 0, 0, 1, 0, 1, 1, 0;
    Faces faces(3, 3);
    faces << 0, 1, 3, 1, 4, 3, 1, 2, 4;
    const SeamVertices none = seam_vertices(faces, std::span(&points, 1));
    EXPECT_TRUE(none.coincident.empty());
    EXPECT_TRUE(none.near.empty());
    // Two closed surfaces that touch have no boundary.
    const TestMesh one = test::tetrahedron();
    Points two(8, 3);
    two << one.points, (-one.points).rowwise() + 2.0 * one.points.row(0);
    Faces both(8, 3);
    both << one.topology.faces(), test::reversed_faces(one.topology.faces()).array() + 4;
    EXPECT_EQ(coincident_vertices(std::span(&two, 1)).size(), 1U);
    EXPECT_TRUE(seam_vertices(both, std::span(&two, 1)).coincident.empty());
}

TEST_F(SeamVerticesOfPatches, AreSaidWithTheirDistance)
{
    EXPECT_TRUE(describe_coincident(cut_.faces, patches(1))
                    .starts_with(join("; ", 2 * doubled_, " of ", cut_.vertices.size(),
                                      " vertices lie on others: ")));
    const std::string near = describe_coincident(cut_.faces, apart(patches(1), 1e-5));
    EXPECT_NE(near.find(join(2 * doubled_, " of ", cut_.vertices.size(),
                             " vertices lie near others, up to 1e-05 of the diagonal away")),
              std::string::npos)
        << near;
    EXPECT_EQ(describe_coincident(cut_.faces, apart(patches(1), 0.1)), "");
    EXPECT_EQ(describe_coincident(mesh_.topology.faces(), mesh_.points), "");
    Points infinite = patches(1);
    infinite(1, 1) = std::numeric_limits<double>::infinity();
    EXPECT_EQ(describe_coincident(cut_.faces, infinite), "");
}

TEST(CoincidentVertices, WeldingDropsFacesThatLoseACorner)
{
    const Faces faces = (Faces(2, 3) << 0, 1, 2, 2, 1, 3).finished();
    const VertexChoice choice = weld(faces, 4, {{1, 2}});
    EXPECT_EQ(choice.faces.rows(), 0);
    EXPECT_EQ(choice.vertices, (std::vector<int>{0, 1, 3}));
}

TEST(CoincidentVertices, KeepingFacesKeepsTheirVerticesInOrder)
{
    const Faces faces = (Faces(3, 3) << 5, 1, 2, 2, 1, 3, 4, 3, 1).finished();
    const VertexChoice choice = keep_faces(faces, 7, {true, false, true});
    EXPECT_EQ(choice.vertices, (std::vector<int>{1, 2, 3, 4, 5}));
    EXPECT_EQ(choice.faces, (Faces(2, 3) << 4, 0, 1, 3, 2, 0).finished());
}

TEST(CoincidentVertices, NameTheArgumentThatBreaksARule)
{
    const Points points = Points::Ones(3, 3);
    Points infinite = points;
    infinite(1, 1) = std::numeric_limits<double>::infinity();
    const auto message = [](auto call) { return test::message_of<InvalidInput>(call); };
    EXPECT_NE(message([&] { (void)coincident_vertices({}); }).find("empty"), std::string::npos);
    EXPECT_NE(message([&] {
                  (void)coincident_vertices(std::vector<Points>{points, Points::Ones(2, 3)});
              }).find("meshes[1] has 2"),
              std::string::npos);
    EXPECT_NE(message([&] { (void)coincident_vertices(std::vector{infinite}); }).find("meshes[0]"),
              std::string::npos);
    const Faces faces = (Faces(1, 3) << 0, 1, 3).finished();
    EXPECT_NE(
        message([&] { (void)seam_vertices(faces, std::vector{points}); }).find("names vertex 3"),
        std::string::npos);
    EXPECT_NE(message([&] { (void)seam_vertices(faces, {}); }).find("empty"), std::string::npos);
    EXPECT_NE(message([&] { (void)weld(faces, 3, {}); }).find("vertex 3"), std::string::npos);
    EXPECT_NE(message([&] { (void)weld(faces, 4, {{0, 7}}); }).find("vertex 7"), std::string::npos);
    EXPECT_NE(message([&] { (void)keep_faces(faces, 4, {}); }).find("0 entries"),
              std::string::npos);
    EXPECT_NE(message([&] { (void)keep_faces(faces, 3, {true}); }).find("vertex 3"),
              std::string::npos);
}

} // namespace
} // namespace shape
