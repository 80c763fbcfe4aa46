// SPDX-License-Identifier: MIT

#include "libshape/registration/landmark_units.h"

#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "tests/support/meshes.h"

namespace shape {
using namespace internal;
namespace {

const std::vector<int> marked{0, 17, 60, 99, 140};

TEST(LandmarkUnits, AreNamedByTheFactorThatBringsAllOntoTheSurface)
{
    test::TestMesh mesh = test::bumpy_sphere(2, 0.2, 1);
    mesh.points = (170.0 * mesh.points).rowwise() + Eigen::RowVector3d(30, -20, 400);
    const Surface surface(mesh.points, mesh.topology.faces());
    const double near = 0.01 * bounding_box_diagonal(mesh.points);
    const Points marks = mesh.points(marked, Eigen::all);
    const auto said = [&](const Points& landmarks) {
        return other_unit_of(landmarks, surface, near, "the scan").value_or("");
    };
    EXPECT_EQ(said(marks), "");
    for (const auto& [factor, words] : std::vector<std::pair<double, std::string>>{
             {1000.0,
              "millimetres and metres?): divided by "
              "1000 all"},
             {0.001, "millimetres and metres?): times 1000 all"},
             {100.0, "divided by 100 all"},
             {0.1, "times 10 all"},
             {25.4, "divided by 25.4 all"},
             {1.0 / 2.54, "times 2.54 all"}})
        EXPECT_NE(said(factor * marks).find(words), std::string::npos)
            << factor << ": " << said(factor * marks);
    // No unit makes landmarks of another mesh, or of one that was moved, lie on this one.
    EXPECT_EQ(said(marks.rowwise() + Eigen::RowVector3d(80, 80, 80)), "");
    EXPECT_EQ(said(3.0 * marks), "");
    Points wrong = 1000.0 * marks;
    wrong.row(2) *= 0.5;
    EXPECT_EQ(said(wrong), "");
    EXPECT_NE(said(1000.0 * marks.topRows(3)).find("divided by 1000 all"), std::string::npos);
    EXPECT_EQ(said(1000.0 * marks.topRows(2)), "");
}

TEST(LandmarkUnits, RasForLpsIsNamed)
{
    test::TestMesh mesh = test::bumpy_sphere(2, 0.2, 1);
    mesh.points = (170.0 * mesh.points).rowwise() + Eigen::RowVector3d(30, -20, 400);
    const Surface surface(mesh.points, mesh.topology.faces());
    const double near = 0.01 * bounding_box_diagonal(mesh.points);
    Points marks = mesh.points(marked, Eigen::all);
    marks.leftCols(2) *= -1.0;
    const auto said = other_unit_of(marks, surface, near, "the scan");
    ASSERT_TRUE(said);
    EXPECT_NE(said->find("RAS and the mesh in LPS, or the reverse: with x and y times -1 all"),
              std::string::npos)
        << *said;
    marks.col(2) *= -1.0; // no program does that
    EXPECT_FALSE(other_unit_of(marks, surface, near, "the scan"));
}

TEST(LandmarkUnits, ThatMeetInOnePlaceOfTheSurfaceSayNothing)
{
    test::TestMesh mesh = test::bumpy_sphere(2, 0.2, 1);
    mesh.points.rowwise() -= mesh.points.row(0).eval(); // through the origin
    const Surface surface(mesh.points, mesh.topology.faces());
    const Points elsewhere =
        mesh.points(marked, Eigen::all).rowwise() + Eigen::RowVector3d(9, 9, 9);
    EXPECT_FALSE(other_unit_of(elsewhere, surface, 0.05, "the scan"));
}

TEST(LandmarkUnits, ACodeForAMissingOneIsNoUnit)
{
    test::TestMesh mesh = test::bumpy_sphere(2, 0.2, 1);
    mesh.points.rowwise() -= mesh.points.row(0).eval(); // through the origin
    const Surface surface(mesh.points, mesh.topology.faces());
    Points marks = mesh.points(marked, Eigen::all);
    // Divided by a thousand it lies on the surface, and all others at the origin.
    marks.row(2) = 1000.0 * mesh.points.row(33);
    const double near = 0.01 * bounding_box_diagonal(mesh.points);
    EXPECT_FALSE(other_unit_of(marks, surface, near, "the scan"));
}

} // namespace
} // namespace shape
