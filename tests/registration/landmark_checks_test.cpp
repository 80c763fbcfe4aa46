// SPDX-License-Identifier: MIT

#include "libshape/registration/landmark_checks.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <string>
#include <vector>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/random.h"
#include "libshape/registration/rigid_start.h"
#include "tests/support/files.h"

namespace shape {
using namespace internal;
namespace {

std::vector<std::string> names_of(Eigen::Index count)
{
    std::vector<std::string> names;
    for (Eigen::Index i = 0; i < count; ++i)
        names.push_back(join("L", i));
    return names;
}

Points random_points(Eigen::Index count, std::uint64_t seed)
{
    Random random(seed);
    Points points(count, 3);
    for (double& number : points.reshaped())
        number = random.normal();
    return points;
}

/// Turned, larger, elsewhere, and a little different.
Points measured_anew(const Points& points, double error)
{
    const Eigen::Matrix3d turn =
        Eigen::AngleAxisd(2.0, Eigen::Vector3d(1.0, -2.0, 0.5).normalized()).toRotationMatrix();
    const Points errors = error * random_points(points.rows(), 99);
    return (12.0 * (points + errors) * turn.transpose()).rowwise() +
           Eigen::RowVector3d(300.0, -20.0, 7.0);
}

/// What a similarity leaves of the spread of the points that it leads to.
double left_over(const Points& from, const Points& to)
{
    return (landmark_start(from, to)(from) - to).norm() / spread(to);
}

std::string percent(double share)
{
    return join(std::round(1000.0 * share) / 10.0, " %");
}

TEST(LandmarkChecks, NameTheTwoThatWereExchanged)
{
    for (const Eigen::Index count : {4, 6, 12}) {
        const Points pattern = random_points(count, 3);
        const Points scan = measured_anew(pattern, 0.03);
        EXPECT_FALSE(mistaken_landmarks(names_of(count), pattern, scan));
        Points slip = scan;
        slip.row(1).swap(slip.row(3));
        const std::string said =
            mistaken_landmarks(names_of(count), pattern, slip).value_or("nothing");
        EXPECT_TRUE(said.starts_with("landmarks 'L1' and 'L3' look exchanged")) << said;
        EXPECT_NE(said.find("differ by " + percent(left_over(pattern, scan)) + " of"),
                  std::string::npos)
            << said;
        EXPECT_NE(said.find("as they are by " + percent(left_over(pattern, slip))),
                  std::string::npos)
            << said;
    }
}

TEST(LandmarkChecks, NameAllThatWereExchanged)
{
    struct Case
    {
        std::vector<Eigen::Index> row_of; ///< The scan's row that landmark i got.
        const char* said;
    };
    for (const Case& c : std::vector<Case>{
             {{1, 0, 3, 2}, "'L0' and 'L1', 'L2' and 'L3' look exchanged"},
             {{1, 2, 0},
              "'L0', 'L2' and 'L1' ('L2' at the place of 'L0', 'L1' at that of 'L2', 'L0' at that "
              "of 'L1') look exchanged"},
             {{2, 3, 0, 1}, "'L0' and 'L2', 'L1' and 'L3' look exchanged"},
             {{1, 0, 3, 2, 5, 4}, "'L0' and 'L1', 'L2' and 'L3', 'L4' and 'L5' look exchanged"}})
        for (const Eigen::Index count : {8, 12, 40}) {
            const Points pattern = random_points(count, 11);
            const Points scan = measured_anew(pattern, 0.03);
            Points slip = scan;
            for (std::size_t i = 0; i < c.row_of.size(); ++i)
                slip.row(static_cast<Eigen::Index>(i)) = scan.row(c.row_of[i]);
            const std::string said =
                mistaken_landmarks(names_of(count), pattern, slip).value_or("nothing");
            EXPECT_TRUE(said.starts_with(join("landmarks ", c.said))) << count << ' ' << said;
            EXPECT_NE(said.find("differ by " + percent(left_over(pattern, scan)) + " of"),
                      std::string::npos)
                << said;
            EXPECT_FALSE(mistaken_landmarks(names_of(count), pattern, scan));
        }
}

TEST(LandmarkChecks, SayNoZerosAreMissingOnesUnlessTheOriginIsOnTheSurface)
{
    Points surface = random_points(200, 2);
    surface.rowwise() += Eigen::RowVector3d(10.0, 0.0, 0.0);
    Points marks = surface.topRows(5);
    const auto said = [&] {
        return test::message_of<InvalidInput>(
            [&] { check_not_zero(names_of(marks.rows()), marks, surface, "the template"); });
    };
    EXPECT_NO_THROW(check_not_zero(names_of(5), marks, surface, "the scan"));
    marks.row(3).setZero();
    EXPECT_TRUE(said().starts_with("landmarks of the template: 'L3' is at 0, 0, 0, which"))
        << said();
    marks.row(1).setZero();
    EXPECT_NE(said().find("template: 'L1' and 'L3' are at 0, 0, 0"), std::string::npos) << said();
    marks.setZero();
    EXPECT_NE(said().find("template: all 5 are at 0, 0, 0"), std::string::npos) << said();
    // An origin that was put at a landmark is no code; two landmarks are not there both.
    const Points moved = surface.rowwise() - surface.row(7);
    marks = moved.topRows(9);
    EXPECT_NO_THROW(check_not_zero(names_of(9), marks, moved, "the scan"));
    marks.row(2).setZero();
    EXPECT_THROW(check_not_zero(names_of(9), marks, moved, "the scan"), InvalidInput);
    // One coordinate of 0 is one.
    marks = surface.topRows(2);
    marks(0, 0) = marks(1, 1) = marks(1, 2) = 0.0;
    EXPECT_NO_THROW(check_not_zero(names_of(2), marks, surface, "the scan"));
}

TEST(LandmarkChecks, SayWhoseLandmarksLieOnALine)
{
    const Points surface = random_points(50, 1);
    Points line = Points::Zero(4, 3);
    line.col(1) << 1.0, 2.0, 4.0, 9.0;
    EXPECT_EQ(
        test::message_of<InvalidInput>([&] { check_not_on_line(line, surface, "the template"); }),
        "landmarks of the template: they lie on a line, which leaves a turn about it open");
    EXPECT_NO_THROW(check_not_on_line(line.topRows(2), surface, "the scan"));
    line(2, 0) = 0.1;
    EXPECT_NO_THROW(check_not_on_line(line, surface, "the scan"));
}

TEST(LandmarkChecks, SayWhoseLandmarksLieInOnePoint)
{
    const Points surface = random_points(50, 1);
    Points marks = surface.row(7).replicate(3, 1);
    const std::string said =
        "landmarks of the scan: all 3 lie in one point, which leaves every turn "
        "open";
    EXPECT_EQ(
        test::message_of<InvalidInput>([&] { check_not_on_line(marks, surface, "the scan"); }),
        said);
    // As near as a hand puts the same one twice.
    marks += 1e-4 * bounding_box_diagonal(surface) * random_points(3, 2);
    EXPECT_EQ(
        test::message_of<InvalidInput>([&] { check_not_on_line(marks, surface, "the scan"); }),
        said);
    marks = surface.row(7).replicate(3, 1) + 0.02 * random_points(3, 2);
    EXPECT_NO_THROW(check_not_on_line(marks, surface, "the scan"));
    EXPECT_NO_THROW(check_not_on_line(surface.row(7).replicate(2, 1), surface, "the scan"));
}

TEST(LandmarkChecks, NameAllThatAreOnePointOnOneSideAlone)
{
    const Points pattern = random_points(5, 4);
    Points scan = measured_anew(pattern, 0.01);
    scan.row(4) = scan.row(2);
    EXPECT_EQ(mistaken_landmarks(names_of(5), pattern, scan),
              "landmarks 'L2' and 'L4' lie on one point of the scan, but not of the template");
    EXPECT_EQ(mistaken_landmarks(names_of(5), scan, pattern),
              "landmarks 'L2' and 'L4' lie on one point of the template, but not of the scan");
    EXPECT_FALSE(mistaken_landmarks(names_of(5), scan, scan));
    scan.row(3) = scan.row(0);
    EXPECT_EQ(
        mistaken_landmarks(names_of(5), pattern, scan),
        "landmarks 'L0' and 'L3', 'L2' and 'L4' lie on one point each of the scan, but not of "
        "the template");
    scan.row(3) = scan.row(2);
    EXPECT_EQ(
        mistaken_landmarks(names_of(5), pattern, scan),
        "landmarks 'L2', 'L3' and 'L4' lie on one point of the scan, but not of the template");
}

TEST(LandmarkChecks, SayThatAllFitAMirrorImage)
{
    const Points pattern = random_points(8, 5);
    const Points scan = measured_anew(pattern, 0.03);
    const Points mirrored = scan * Eigen::RowVector3d(1.0, 1.0, -1.0).asDiagonal();
    const std::string said = mistaken_landmarks(names_of(8), pattern, mirrored).value_or("nothing");
    EXPECT_TRUE(said.starts_with("the landmarks of the scan look like a mirror image")) << said;
    EXPECT_NE(said.find("differ by " + percent(left_over(pattern, scan)) + " of"),
              std::string::npos)
        << said;
    EXPECT_NE(said.find("as they are by " + percent(left_over(pattern, mirrored))),
              std::string::npos)
        << said;
    // Left for right in all names of a shape that is its own mirror image.
    Points symmetric(8, 3);
    symmetric.topRows(4) = random_points(4, 6);
    symmetric.bottomRows(4) =
        symmetric.topRows(4) * Eigen::RowVector3d(-1.0, 1.0, 1.0).asDiagonal();
    Points left_for_right = measured_anew(symmetric, 0.02);
    left_for_right.topRows(4).swap(left_for_right.bottomRows(4));
    EXPECT_NE(mistaken_landmarks(names_of(8), symmetric, left_for_right)
                  .value_or("nothing")
                  .find("exchange left and right"),
              std::string::npos);
}

TEST(LandmarkChecks, SayNothingOfWhatNoSlipExplains)
{
    // A plane is its own mirror image.
    Points flat = random_points(6, 7);
    flat.col(2).setZero();
    EXPECT_FALSE(mistaken_landmarks(
        names_of(6), flat, measured_anew(flat * Eigen::RowVector3d(-1, 1, 1).asDiagonal(), 0.0)));
    // Three: too few. Four: several exchanges explain whatever there is.
    const Points pattern = random_points(8, 8);
    Points slip = measured_anew(pattern, 0.0);
    slip.row(0).swap(slip.row(1));
    EXPECT_FALSE(mistaken_landmarks(names_of(3), pattern.topRows(3),
                                    measured_anew(pattern.topRows(3), 0.5)));
    slip.row(2).swap(slip.row(3));
    EXPECT_FALSE(mistaken_landmarks(names_of(4), pattern.topRows(4), slip.topRows(4)));
    // Poses and other animals: large differences are no slip.
    for (std::uint64_t seed = 10; seed < 60; ++seed) {
        const Points other = random_points(8, seed) + pattern;
        EXPECT_FALSE(mistaken_landmarks(names_of(8), pattern, other)) << seed;
    }
}

TEST(LandmarkChecks, RefuseCodesByName)
{
    const Points surface = random_points(50, 1);
    Points marks = surface.topRows(5);
    EXPECT_NO_THROW(check_not_far(names_of(5), marks, surface, "the scan"));
    marks.row(2).setConstant(-9999.0);
    marks(4, 1) = -9999.0; // one coordinate is enough
    const std::string said = test::message_of<InvalidInput>(
        [&] { check_not_far(names_of(5), marks, surface, "the template"); });
    EXPECT_TRUE(said.starts_with("landmarks of the template: 'L2' lies ")) << said;
    EXPECT_NE(said.find(", 'L4' lies "), std::string::npos) << said;
    EXPECT_EQ(said.find("'L1'"), std::string::npos) << said;
    // All of them in another unit, or elsewhere, are no codes.
    EXPECT_NO_THROW(
        check_not_far(names_of(5), 1000.0 * surface.topRows(5), 0.01 * surface, "the scan"));
    // 20 diagonals are the bound.
    Points two = surface.topRows(2);
    const double diagonal = bounding_box_diagonal(surface);
    const Eigen::RowVector3d centre =
        0.5 * (surface.colwise().minCoeff() + surface.colwise().maxCoeff());
    two.row(1) = centre + Eigen::RowVector3d(0.0, 19.9 * diagonal, 0.0);
    EXPECT_NO_THROW(check_not_far(names_of(2), two, surface, "the scan"));
    two.row(1) = centre + Eigen::RowVector3d(0.0, 20.1 * diagonal, 0.0);
    EXPECT_THROW(check_not_far(names_of(2), two, surface, "the scan"), InvalidInput);
}

} // namespace
} // namespace shape
