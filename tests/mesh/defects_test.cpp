// SPDX-License-Identifier: MIT

#include "libshape/mesh/defects.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <initializer_list>
#include <limits>

#include "tests/support/meshes.h"

namespace shape {
namespace {

Faces faces_of(std::initializer_list<Eigen::RowVector3i> rows)
{
    Faces faces(static_cast<Eigen::Index>(rows.size()), 3);
    std::copy(rows.begin(), rows.end(), faces.rowwise().begin());
    return faces;
}

int count(const std::vector<Defect>& defects, DefectKind kind)
{
    return static_cast<int>(std::count_if(defects.begin(), defects.end(),
                                          [&](const Defect& d) { return d.kind == kind; }));
}

/// The only defect of these faces must be this one, at this place, and its message must say so.
void expect_one(const Faces& faces, int vertices, DefectKind kind, int face, int vertex,
                const std::string& part)
{
    const std::vector<Defect> defects = find_defects(faces, vertices);
    ASSERT_EQ(defects.size(), 1u);
    EXPECT_EQ(defects[0].kind, kind);
    EXPECT_EQ(defects[0].face, face);
    EXPECT_EQ(defects[0].vertex, vertex);
    EXPECT_NE(defects[0].message.find(part), std::string::npos) << defects[0].message;
}

TEST(FindDefects, FindsNoneInGoodMeshes)
{
    for (const test::TestMesh& mesh : test::sample_meshes()) {
        EXPECT_TRUE(find_defects(mesh.topology.faces(), mesh.topology.vertex_count()).empty());
        EXPECT_TRUE(find_degenerate_geometry(mesh.topology.faces(), mesh.points).empty());
    }
}

TEST(FindDefects, NamesThePlaceAndTheRule)
{
    expect_one(faces_of({}), 3, DefectKind::Empty, -1, -1, "3 vertices and 0 faces");
    expect_one(faces_of({{0, 1, 2}, {0, 2, 7}}), 4, DefectKind::IndexOutOfRange, 1, 7,
               "face 1 names vertex 7, the mesh has 4 (0 to 3)");
    expect_one(faces_of({{0, 1, -1}}), 2, DefectKind::IndexOutOfRange, 0, -1, "vertex -1");
    expect_one(faces_of({{0, 1, 2}, {2, 1, 2}}), 3, DefectKind::DegenerateFace, 1, 2,
               "face 1 (2, 1, 2) names a vertex twice");
    expect_one(faces_of({{0, 1, 2}, {1, 0, 3}, {0, 1, 4}}), 5, DefectKind::NonManifoldEdge, 2, 0,
               "edge 0-1 has 3 faces (0, 1, 2");
    expect_one(faces_of({{0, 1, 2}, {0, 1, 3}}), 4, DefectKind::FlippedFace, 1, 0,
               "faces 0 and 1 both run 0 -> 1; flip one");
    expect_one(faces_of({{2, 1, 0}, {1, 0, 3}}), 4, DefectKind::FlippedFace, 1, 0, "run 1 -> 0");
    expect_one(faces_of({{0, 1, 2}}), 4, DefectKind::IsolatedVertex, -1, 3,
               "vertex 3 belongs to no face");
    expect_one(faces_of({{0, 1, 2}, {3, 4, 5}}), 6, DefectKind::SeveralComponents, 1, 3,
               "2 components (face 1 is not connected with face 0)");
}

TEST(FindDefects, NamesDuplicatesWhateverCornerTheyStartAt)
{
    for (const Eigen::RowVector3i& copy : {Eigen::RowVector3i(2, 3, 1), {3, 2, 1}}) {
        const std::vector<Defect> defects = find_defects(faces_of({{0, 1, 2}, {1, 3, 2}, copy}), 4);
        ASSERT_EQ(count(defects, DefectKind::DuplicateFace), 1);
        EXPECT_EQ(defects[0].face, 2);
        EXPECT_NE(defects[0].message.find("face 2 repeats face 1"), std::string::npos);
    }
}

TEST(FindDefects, NamesABowTieWithinOneComponent)
{
    // A ring of quads around vertex 0's two fans: pinch two opposite vertices of a cylinder rim.
    const test::TestMesh mesh = test::open_cylinder(8, 3);
    Faces faces = mesh.topology.faces();
    for (int& v : faces.reshaped())
        v = v == 4 ? 0 : v > 4 ? v - 1 : v;
    expect_one(faces, mesh.topology.vertex_count() - 1, DefectKind::BowTie,
               find_defects(faces, mesh.topology.vertex_count() - 1).at(0).face, 0,
               "vertex 0 joins separate fans");
}

TEST(FindDefects, CountsABowTieOfTwoTrianglesAsTwoComponents)
{
    const std::vector<Defect> defects = find_defects(faces_of({{0, 1, 2}, {0, 3, 4}}), 5);
    EXPECT_EQ(count(defects, DefectKind::BowTie), 1);
    EXPECT_EQ(count(defects, DefectKind::SeveralComponents), 1);
}

TEST(FindDefects, ListsAsManyOfAKindAsTheLimitAllows)
{
    const Faces faces = faces_of({{0, 1, 2}});
    EXPECT_EQ(find_defects(faces, 20).size(), 5u);
    EXPECT_EQ(find_defects(faces, 20, 2).size(), 2u);
    EXPECT_EQ(find_defects(faces, 20, 100).size(), 17u);
}

TEST(FindDegenerateGeometry, NamesVerticesThatAreNotFinite)
{
    test::TestMesh mesh = test::tetrahedron();
    mesh.points(2, 0) = std::numeric_limits<double>::quiet_NaN();
    mesh.points(3, 1) = -std::numeric_limits<double>::infinity();
    const std::vector<Defect> defects =
        find_degenerate_geometry(mesh.topology.faces(), mesh.points);
    EXPECT_EQ(count(defects, DefectKind::NotFinite), 2);
    EXPECT_EQ(defects[0].vertex, 2);
    EXPECT_EQ(defects[1].vertex, 3);
}

TEST(FindDegenerateGeometry, DrawsTheLineAtTheDocumentedRatio)
{
    // A needle of length 1 and height h has area h / 2: degenerate if h / 2 <= 1e-14.
    const Faces faces = faces_of({{0, 1, 2}});
    for (const double scale : {1e-3, 1.0, 1e6}) {
        const auto defects = [&](double height) {
            Points points(3, 3);
            points << 0, 0, 0, 1, 0, 0, 0.5, height, 0;
            return find_degenerate_geometry(faces, scale * points);
        };
        EXPECT_TRUE(defects(2.1e-14).empty());
        ASSERT_EQ(defects(1.9e-14).size(), 1u);
        EXPECT_EQ(defects(0.0).at(0).kind, DefectKind::DegenerateTriangle);
        EXPECT_EQ(defects(0.0).at(0).face, 0);
    }
    EXPECT_EQ(find_degenerate_geometry(faces, Points::Zero(3, 3)).size(), 1u);
}

TEST(FindDegenerateGeometry, NamesTheLongestEdgeWherePowersOfItOverflow)
{
    const Faces faces = faces_of({{0, 1, 2}});
    Points points(3, 3);
    points << 0, 0, 0, 1, 0, 0, 0.5, 0.6, 0;
    for (const double sound : {1e-59, 1.0, 0.99e60})
        EXPECT_TRUE(find_degenerate_geometry(faces, sound * points).empty()) << sound;
    for (const double odd : {1e-300, 1e-61, 1.01e60, 1e200, 1e308}) {
        const std::vector<Defect> defects = find_degenerate_geometry(faces, odd * points);
        ASSERT_EQ(defects.size(), 1u) << odd; // squares of 0 and infinity say nothing of faces
        EXPECT_EQ(defects[0].kind, DefectKind::SizeOutOfRange);
        EXPECT_EQ(defects[0].face, 0);
        EXPECT_NE(defects[0].message.find("the longest edge, 0-1,"), std::string::npos)
            << defects[0].message;
    }
    // A vertex far away that belongs to no face is no edge.
    points.conservativeResize(4, 3);
    points.row(3) << 1e200, 0, 0;
    EXPECT_TRUE(find_degenerate_geometry(faces, points).empty());
}

TEST(FindDegenerateGeometry, SaysWhereCoordinatesAreTooCoarse)
{
    const test::TestMesh sphere = test::icosphere(3);
    const Points far = sphere.points.array() + 3.2e6;
    const std::vector<Defect> found =
        find_degenerate_geometry(sphere.topology.faces(), far.cast<float>().cast<double>());
    ASSERT_GE(found.size(), 2U);
    EXPECT_NE(found[0].message.find("; coordinates are multiples of 0.25, "), std::string::npos)
        << found[0].message;
    EXPECT_EQ(found[1].message.find("multiples"), std::string::npos); // once is enough
    Points fine = sphere.points;
    fine.row(sphere.topology.faces()(0, 0)) = fine.row(sphere.topology.faces()(0, 1));
    EXPECT_EQ(
        find_degenerate_geometry(sphere.topology.faces(), fine).at(0).message.find("multiples"),
        std::string::npos);
}

} // namespace
} // namespace shape
