// SPDX-License-Identifier: MIT

#include "libshape/mesh/coincident_vertices.h"

#include <gtest/gtest.h>

#include "libshape/base/error.h"
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
    EXPECT_EQ(describe_coincident(points), "");
    points(2, 2) = 0.0;
    EXPECT_NE(describe_coincident(points).find("2 of 3 vertices"), std::string::npos);
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
    EXPECT_NE(message([&] { (void)weld(faces, 3, {}); }).find("vertex 3"), std::string::npos);
    EXPECT_NE(message([&] { (void)weld(faces, 4, {{0, 7}}); }).find("vertex 7"), std::string::npos);
    EXPECT_NE(message([&] { (void)keep_faces(faces, 4, {}); }).find("0 entries"),
              std::string::npos);
    EXPECT_NE(message([&] { (void)keep_faces(faces, 3, {true}); }).find("vertex 3"),
              std::string::npos);
}

} // namespace
} // namespace shape
