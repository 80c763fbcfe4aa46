// SPDX-License-Identifier: MIT

#include "libshape/mesh/collection.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <utility>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/mesh/coincident_vertices.h"
#include "tests/support/meshes.h"

namespace shape {
using namespace internal;
namespace {

NamedMesh named(const std::string& name, const test::TestMesh& mesh)
{
    return {name, name + ".ply", mesh.points, mesh.topology.faces()};
}

/// The message of collect() for the open patch and this changed copy of it.
std::string message_for(const NamedMesh& changed)
{
    try {
        (void)collect({named("first", test::open_patch(4, 1)), changed});
    } catch (const InvalidInput& error) {
        return error.what();
    }
    return "nothing was thrown";
}

void expect_says(const std::string& message, const std::vector<std::string>& parts)
{
    for (const std::string& part : parts)
        EXPECT_NE(message.find(part), std::string::npos) << "'" << part << "' in: " << message;
}

NamedMesh changed_copy()
{
    return named("second", test::open_patch(4, 2));
}

TEST(Collect, KeepsOrderNamesAndPositions)
{
    const test::TestMesh patch = test::open_patch(4, 1);
    const Collection collection = collect({named("b", patch), named("a", test::open_patch(4, 2))});
    EXPECT_EQ(collection.size(), 2u);
    EXPECT_EQ(collection.names, (std::vector<std::string>{"b", "a"}));
    EXPECT_EQ(collection.points[0], patch.points);
    EXPECT_EQ(collection.points[1], test::open_patch(4, 2).points);
    EXPECT_TRUE(collection.topology == patch.topology);
    EXPECT_TRUE(collection.labels.empty());
}

TEST(Subset, KeepsChosenMeshesWithTheirLabels)
{
    Collection collection =
        collect({named("a", test::open_patch(4, 1)), named("b", test::open_patch(4, 2)),
                 named("c", test::open_patch(4, 3))});
    collection.labels = {{"age", {"1", "2", "3"}}};
    const Collection chosen = subset(collection, {2, 0});
    EXPECT_EQ(chosen.names, (std::vector<std::string>{"c", "a"}));
    EXPECT_EQ(chosen.points[0], collection.points[2]);
    EXPECT_EQ(chosen.labels[0].name, "age");
    EXPECT_EQ(chosen.labels[0].values, (std::vector<std::string>{"3", "1"}));
    EXPECT_TRUE(chosen.topology == collection.topology);
}

TEST(Subset, NamesAnIndexOutOfRange)
{
    const Collection collection =
        collect({named("a", test::open_patch(4, 1)), named("b", test::open_patch(4, 2))});
    try {
        (void)subset(collection, {1, 2});
        FAIL() << "nothing was thrown";
    } catch (const InvalidInput& error) {
        expect_says(error.what(), {"meshes[1] is 2", "in [0, 2)"});
    }
}

TEST(Collect, NamesOtherCounts)
{
    expect_says(
        message_for(named("second", test::open_patch(5, 1))),
        {"second.ply: 36 vertices and 50 faces", "first.ply has 25 and 32", "different counts"});
}

TEST(Collect, NamesPermutedVertices)
{
    NamedMesh mesh = changed_copy();
    const int count = static_cast<int>(mesh.points.rows());
    for (int& v : mesh.faces.reshaped())
        v = (v + 7) % count;
    expect_says(message_for(mesh), {"second.ply: face 0 is (", "in first.ply it is (",
                                    "vertices are probably permuted"});
}

TEST(Collect, NamesMeshesOfOneFile)
{
    NamedMesh mesh = changed_copy();
    NamedMesh reference = mesh;
    reference.name = "left";
    mesh.name = "right";
    mesh.faces.row(3).swap(mesh.faces.row(9));
    expect_says(describe_correspondence_break(reference, mesh),
                {"second.ply: mesh right: face 3 is", "in second.ply: mesh left it is"});
}

TEST(Collect, NamesPermutedFaces)
{
    NamedMesh mesh = changed_copy();
    mesh.faces.row(3).swap(mesh.faces.row(9));
    expect_says(message_for(mesh), {"second.ply: face 3 ", "another order"});
    mesh = changed_copy();
    std::rotate(mesh.faces.row(5).begin(), mesh.faces.row(5).begin() + 1, mesh.faces.row(5).end());
    expect_says(message_for(mesh), {"second.ply: face 5 ", "another corner"});
}

TEST(Collect, NamesFlippedOrientation)
{
    NamedMesh mesh = changed_copy();
    mesh.faces.col(1).swap(mesh.faces.col(2));
    expect_says(message_for(mesh), {"orientation of every face is flipped"});
    mesh = changed_copy();
    for (const int f : {6, 20})
        std::swap(mesh.faces(f, 0), mesh.faces(f, 1));
    expect_says(message_for(mesh), {"face 6 ", "2 faces flipped"});
}

TEST(Collect, NamesOtherDiagonals)
{
    // Faces 0 and 1 are the quad p q s t, split along p s; split it along q t.
    NamedMesh mesh = changed_copy();
    const int p = mesh.faces(0, 0);
    const int q = mesh.faces(0, 1);
    const int s = mesh.faces(0, 2);
    const int t = mesh.faces(1, 2);
    ASSERT_EQ(mesh.faces(1, 1), s);
    mesh.faces.row(0) << p, q, t;
    mesh.faces.row(1) << q, s, t;
    expect_says(message_for(mesh), {"face 0 ", "1 quad is cut along the other diagonal (vertices ",
                                    "read the files that have the polygons (option triangulate)"});
    // Turned over as well.
    mesh.faces.col(1).swap(mesh.faces.col(2));
    expect_says(message_for(mesh),
                {"orientation of every face is flipped, and 1 quad is cut along the other diagonal",
                 "reverse the faces and read the files"});
    // Beside another slip it is not the cause.
    mesh = changed_copy();
    mesh.faces.row(0) << p, q, t;
    mesh.faces.row(1) << q, s, t;
    std::swap(mesh.faces(9, 0), mesh.faces(9, 1));
    expect_says(message_for(mesh), {"3 faces connect other vertices"});
}

/// A grid of quads, each cut by the one diagonal or the other.
Faces cut_grid(int side, const std::function<bool(int, int)>& is_other)
{
    Faces faces(2 * side * side, 3);
    for (int i = 0, f = 0; i < side; ++i)
        for (int j = 0; j < side; ++j, f += 2) {
            const int a = i * (side + 1) + j, b = a + 1, d = a + side + 1, c = d + 1;
            if (is_other(i, j))
                faces.middleRows(f, 2) << a, b, d, b, c, d;
            else
                faces.middleRows(f, 2) << a, b, c, a, c, d;
        }
    return faces;
}

TEST(Collect, TellsOtherDiagonalsFromPermutedVertices)
{
    constexpr int side = 6;
    const int count = (side + 1) * (side + 1);
    Points points(count, 3);
    for (int i = 0; i < count; ++i)
        points.row(i) << i % (side + 1), i / (side + 1), 0.1 * std::sin(i);
    const NamedMesh reference{"first", "first.ply", points,
                              cut_grid(side, [](int, int) { return false; })};
    const auto said = [&](const Faces& faces) {
        return describe_correspondence_break(reference, {"second", "second.ply", points, faces});
    };
    // All of them: the degrees agree as a set, as those of permuted vertices do.
    expect_says(
        said(cut_grid(side, [](int, int) { return true; })),
        {"36 quads are cut along their other diagonal, first that of vertices 0, 1, 8, 7;"});
    expect_says(said(cut_grid(side, [](int i, int j) { return (i + j) % 2 == 0; })),
                {"18 quads are cut along their other diagonal"});
    // Two vertices exchanged, inside, at the rim, next to each other and apart; all moved on; the grid transposed.
    for (const auto& [a, b] :
         std::vector<std::pair<int, int>>{{8, 9}, {8, 24}, {1, 3}, {0, 48}, {1, 9}}) {
        Faces faces = reference.faces;
        for (int& v : faces.reshaped())
            v = v == a ? b : v == b ? a : v;
        expect_says(said(faces), {"vertices are probably permuted"});
    }
    Faces faces = reference.faces;
    for (int& v : faces.reshaped())
        v = (v + 1) % count;
    expect_says(said(faces), {"vertices are probably permuted"});
}

TEST(Collect, NamesAnotherConnectivity)
{
    // As many vertices and faces, but other faces throughout: degrees are far apart.
    NamedMesh fan = changed_copy();
    for (int f = 0; f < fan.faces.rows(); ++f)
        fan.faces.row(f) << 0, 1 + f % 24, 1 + (f + 1) % 24;
    expect_says(message_for(fan), {"another connectivity"});
}

TEST(Collect, NamesDegenerateGeometryAndTheMeshThatHasIt)
{
    NamedMesh mesh = changed_copy();
    mesh.points.row(7) = mesh.points.row(8);
    expect_says(message_for(mesh), {"second.ply: face ", "no area"});
    mesh = changed_copy();
    mesh.points(7, 1) = std::numeric_limits<double>::infinity();
    expect_says(message_for(mesh), {"second.ply: vertex 7 ", "not finite"});
}

TEST(Collect, NamesARepeatedName)
{
    NamedMesh mesh = changed_copy();
    mesh.name = "first";
    expect_says(message_for(mesh), {"second.ply", "'first' occurs twice"});
}

TEST(Collect, NamesTheDefectOfTheFirstMesh)
{
    NamedMesh mesh = changed_copy();
    std::swap(mesh.faces(4, 0), mesh.faces(4, 1));
    try {
        (void)collect({mesh});
        FAIL() << "nothing was thrown";
    } catch (const InvalidInput& error) {
        expect_says(error.what(), {"second.ply: ", "flip one"});
    }
}

/// Two triangles that share an edge, whose vertices both have.
NamedMesh split_square()
{
    NamedMesh mesh{"split", "split.ply", Points(6, 3), Faces(2, 3)};
    mesh.points << 0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0;
    mesh.faces << 0, 1, 2, 3, 5, 4;
    return mesh;
}

/// Whether a mesh that is refused is called split; what it is called then.
bool is_split(const NamedMesh& mesh, const std::string& said = "4 of 6 vertices lie on others")
{
    try {
        (void)collect({mesh});
    } catch (const SplitSurface& error) {
        expect_says(error.what(), {mesh.path + ": ", said});
        return true;
    } catch (const InvalidInput& error) {
        EXPECT_EQ(std::string(error.what()).find("lie on others"), std::string::npos);
        return false;
    }
    ADD_FAILURE() << "nothing was thrown";
    return false;
}

TEST(Collect, SaysThatASurfaceIsSplitWhereVerticesLieOnOneAnother)
{
    NamedMesh mesh = split_square();
    EXPECT_TRUE(is_split(mesh));
    mesh.points.bottomRows(3).array() += 0.5;
    EXPECT_FALSE(is_split(mesh));
    // A third piece stays one, and both others become one all the same.
    mesh = split_square();
    mesh.points.conservativeResize(9, 3);
    mesh.points.bottomRows(3) = mesh.points.topRows(3).array() + 5.0;
    mesh.faces.conservativeResize(3, 3);
    mesh.faces.row(2) << 6, 7, 8;
    EXPECT_TRUE(is_split(mesh, "4 of 9 vertices lie on others"));
}

TEST(Collect, CallsASurfaceSplitOnlyIfWeldingMendsIt)
{
    NamedMesh mesh = split_square();
    mesh.faces(1, 1) = 6;
    EXPECT_FALSE(is_split(mesh)); // there is no vertex 6
    mesh = split_square();
    mesh.points.conservativeResize(7, 3);
    mesh.points.row(6) << 0, -1, 0;
    mesh.faces.conservativeResize(3, 3);
    mesh.faces.row(2) << 0, 1, 6;
    EXPECT_FALSE(is_split(mesh)); // faces 0 and 2 disagree
    // Only a corner is shared: welded, it would join two fans.
    mesh = split_square();
    mesh.points.row(4) << 2, 0, 0;
    EXPECT_FALSE(is_split(mesh));
    mesh.points(5, 2) = std::numeric_limits<double>::quiet_NaN();
    EXPECT_FALSE(is_split(mesh));
}

TEST(Collect, RefusesNoMesh)
{
    EXPECT_THROW((void)collect({}), InvalidInput);
}

TEST(DescribeCorrespondenceBreak, IsEmptyForEqualFaces)
{
    EXPECT_EQ(describe_correspondence_break(named("first", test::open_patch(4, 1)), changed_copy()),
              "");
}

} // namespace
} // namespace shape
