// SPDX-License-Identifier: MIT

#include "libshape/report/render.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <limits>
#include <numbers>
#include <utility>
#include <vector>

#include "libshape/base/error.h"
#include "libshape/synthetic/synthetic.h"
#include "tests/support/meshes.h"

namespace shape {
namespace {

const Colour white{255, 255, 255};

/// 40 by 40 pixels that show [-2, 2]^2.
RenderOptions small_picture()
{
    RenderOptions options;
    options.width = 40;
    options.height = 40;
    options.pixel_size = 0.1;
    return options;
}

Points rows(std::initializer_list<Eigen::RowVector3d> list)
{
    Points points(static_cast<Eigen::Index>(list.size()), 3);
    Eigen::Index v = 0;
    for (const Eigen::RowVector3d& p : list)
        points.row(v++) = p;
    return points;
}

TEST(RenderMesh, FillsTheTriangleAndNothingElse)
{
    // x >= -1, y >= -1, x + y <= 1: in pixels columns from 10, rows to 30, below the diagonal.
    const Faces faces{{0, 1, 2}};
    const Image image =
        render_mesh(faces, rows({{-1, -1, 0}, {2, -1, 0}, {-1, 2, 0}}), small_picture());
    for (int y = 0; y < 40; ++y)
        for (int x = 0; x < 40; ++x) {
            const double right = 0.1 * (x + 0.5) - 2.0;
            const double up = 2.0 - 0.1 * (y + 0.5);
            const double inside = std::min({right + 1.0, up + 1.0, (1.0 - right - up) / 1.4143});
            if (inside > 0.08) {
                EXPECT_NE(image.at(x, y), white) << x << " " << y;
            }
            if (inside < -0.08) {
                EXPECT_EQ(image.at(x, y), white) << x << " " << y;
            }
        }
}

TEST(RenderMesh, HasNoSeamsWhereALargeImageIsMadeInBands)
{
    RenderOptions options = small_picture(); // more samples than are made at once
    options.width = 4000;
    options.height = 130;
    const Faces faces{{0, 1, 2}};
    const Image image =
        render_mesh(faces, rows({{-1000, -1000, 0}, {1000, -1000, 0}, {0, 1000, 0}}), options);
    ASSERT_NE(image.at(0, 0), white);
    for (int x = 0; x < options.width; x += 100)
        for (int y = 0; y < options.height; ++y)
            EXPECT_EQ(image.at(x, y), image.at(x, 0)) << x << " " << y;
}

TEST(RenderMesh, CoversEdgePixelsByTheirShare)
{
    // The left edge runs through the middle of column 10.
    const Faces faces{{0, 1, 2}};
    RenderOptions options = small_picture();
    options.surface = {0, 0, 0};
    const Image image =
        render_mesh(faces, rows({{-0.95, -9, 0}, {9, 0, 0}, {-0.95, 9, 0}}), options);
    EXPECT_EQ(image.at(9, 20), white);
    EXPECT_LT(image.at(11, 20).red, 80);
    // Half of white light is 188 in sRGB; one of three sample columns more or less is 157 or 213.
    EXPECT_GT(image.at(10, 20).red, 150);
    EXPECT_LT(image.at(10, 20).red, 220);
}

TEST(RenderMesh, DrawsWhatIsNearerInFrontWhateverTheOrderOfFaces)
{
    const Points points = rows({{-1, -1, 0},
                                {1, -1, 0},
                                {0, 1.5, 0}, // behind
                                {-1, -1, 1},
                                {1, -1, 1},
                                {0, 1.5, 1}});
    RenderOptions options = small_picture();
    const Colour red{255, 0, 0};
    const Colour blue{0, 0, 255};
    options.vertex_colours = {red, red, red, blue, blue, blue};
    for (const Faces& faces : {Faces{{0, 1, 2}, {3, 4, 5}}, Faces{{3, 4, 5}, {0, 1, 2}}}) {
        const Colour middle = render_mesh(faces, points, options).at(20, 20);
        EXPECT_LT(middle.red, 60);
        EXPECT_GT(middle.blue, 100);
    }
}

TEST(RenderMesh, ShowsBacksDarker)
{
    const Points points = rows({{-1, -1, 0}, {1, -1, 0}, {0, 1.5, 0}});
    const Colour front = render_mesh(Faces{{0, 1, 2}}, points, small_picture()).at(20, 20);
    const Colour back = render_mesh(Faces{{0, 2, 1}}, points, small_picture()).at(20, 20);
    EXPECT_LT(back.green + 20, front.green);
    EXPECT_GT(back.green, 20);
}

TEST(RenderMesh, RefusesMeshesThatCannotBeSeen)
{
    const Points points = rows({{-1, -1, 0}, {2, -1, 0}, {-1, 2, 0}});
    const Faces face{{0, 1, 2}};
    Points broken = points;
    broken(1, 2) = std::numeric_limits<double>::quiet_NaN();
    const std::vector<std::pair<Faces, Points>> meshes{
        {Faces(0, 3), Points(0, 3)}, {Faces(0, 3), points},
        {face, Points(0, 3)},        {face, broken},
        {Faces{{0, 1, 3}}, points},  {Faces{{0, -1, 2}}, points}};
    for (const auto& [faces, places] : meshes) {
        EXPECT_THROW((void)render_mesh(faces, places, small_picture()), InvalidInput);
        EXPECT_THROW((void)automatic_view(faces, places), InvalidInput);
    }
}

TEST(RenderMesh, CastsShadows)
{
    // A plate between the key light (from the upper left) and the middle of a wall.
    Points points = rows({{-2, -2, 0}, {2, -2, 0}, {2, 2, 0}, {-2, 2, 0}});
    const Faces wall{{0, 1, 2}, {0, 2, 3}};
    const Colour lit = render_mesh(wall, points, small_picture()).at(20, 20);
    const Eigen::RowVector3d to_light = Eigen::RowVector3d(-0.58, 0.48, 0.66).normalized();
    Points with_plate(8, 3);
    with_plate << points, points * Eigen::RowVector3d(0.25, 0.25, 1.0).asDiagonal();
    with_plate.bottomRows(4).rowwise() += to_light;
    const Faces both{{0, 1, 2}, {0, 2, 3}, {4, 5, 6}, {4, 6, 7}};
    const Colour shaded = render_mesh(both, with_plate, small_picture()).at(20, 20);
    EXPECT_LT(shaded.green + 15, lit.green);
}

TEST(RenderMesh, IsLitFromTheUpperLeft)
{
    const test::TestMesh ball = test::icosphere(3);
    const Image image = render_mesh(ball.topology.faces(), ball.points, small_picture());
    EXPECT_GT(image.at(15, 15).green, image.at(25, 25).green + 30);
    EXPECT_GT(image.at(20, 20).red, image.at(20, 20).blue); // of the warm colour of the surface
}

TEST(RenderMesh, ShowsWhatIsAroundItsCentre)
{
    const Faces faces{{0, 1, 2}};
    const Points points = rows({{-1, -1, 0}, {1, -1, 0}, {0, 1.5, 0}});
    RenderOptions options = small_picture();
    const Image image = render_mesh(faces, points, options);
    options.centre = {0.5, -1.0}; // 5 pixels to the right, 10 down
    const Image shifted = render_mesh(faces, points, options);
    for (int y = 10; y < 40; ++y)
        for (int x = 5; x < 40; ++x)
            EXPECT_EQ(shifted.at(x - 5, y - 10) == white, image.at(x, y) == white) << x << " " << y;
    EXPECT_EQ(shifted.at(15, 10), image.at(20, 20));
}

TEST(RenderMesh, DrawsEdgesSharpThatBendMoreThanTheCreaseAngle)
{
    // A roof whose ridge, at x = 0, bends by 90 degrees; its left side, near the ridge and half way down.
    const Points roof = rows({{0, -2, 0},
                              {0, 2, 0},
                              {-1.5, 2, -1.5},
                              {-1.5, -2, -1.5},
                              {1.5, -2, -1.5},
                              {1.5, 2, -1.5}});
    const Faces faces{{0, 1, 2}, {0, 2, 3}, {1, 0, 4}, {1, 4, 5}};
    const auto contrast = [&](double crease_angle) {
        RenderOptions options = small_picture();
        options.crease_angle = crease_angle;
        const Image image = render_mesh(faces, roof, options);
        return std::abs(image.at(18, 20).green - image.at(12, 20).green);
    };
    EXPECT_LE(contrast(89.0), 3);
    EXPECT_GT(contrast(91.0), 10);
}

TEST(RenderMesh, RefusesOptionsOutOfRange)
{
    const Points points = rows({{-1, -1, 0}, {1, -1, 0}, {0, 1.5, 0}});
    RenderOptions options = small_picture();
    options.width = 0;
    EXPECT_THROW((void)render_mesh(Faces{{0, 1, 2}}, points, options), InvalidInput);
    options = small_picture();
    options.pixel_size = 0.0;
    EXPECT_THROW((void)render_mesh(Faces{{0, 1, 2}}, points, options), InvalidInput);
    options = small_picture();
    options.vertex_colours = {white};
    EXPECT_THROW((void)render_mesh(Faces{{0, 1, 2}}, points, options), InvalidInput);
}

TEST(ViewRotation, TurnsTheNamedAxesToTheViewer)
{
    const Eigen::Matrix3d front = view_rotation({});
    EXPECT_TRUE(front.isIdentity(1e-15));
    const auto viewer = [](double azimuth, double elevation) {
        return Eigen::Vector3d(view_rotation({azimuth, elevation}).row(2).transpose());
    };
    EXPECT_TRUE(viewer(90, 0).isApprox(Eigen::Vector3d::UnitX(), 1e-14));
    EXPECT_TRUE(viewer(180, 0).isApprox(-Eigen::Vector3d::UnitZ(), 1e-14));
    EXPECT_TRUE(viewer(0, 90).isApprox(Eigen::Vector3d::UnitY(), 1e-14));
    for (const double azimuth : {-200.0, -30.0, 0.0, 77.0})
        for (const double elevation : {-90.0, -20.0, 45.0, 90.0}) {
            const Eigen::Matrix3d r = view_rotation({azimuth, elevation});
            EXPECT_TRUE((r * r.transpose()).isIdentity(1e-14));
            EXPECT_NEAR(r.determinant(), 1.0, 1e-14);
            EXPECT_GE((r * Eigen::Vector3d::UnitY()).y(), -1e-14); // +y is never down
            EXPECT_NEAR((r * Eigen::Vector3d::UnitY()).x(), 0.0, 1e-14);
        }
}

TEST(AutomaticView, LooksAFaceIntoTheEyesHoweverItIsTurned)
{
    const Collection set = make_synthetic("faces", {.count = 1, .vertices = 1000});
    const Faces& faces = set.topology.faces();
    EXPECT_TRUE(automatic_view(faces, set.points[0]).isIdentity(1e-12));
    for (const double degrees : {-120.0, -50.0, 40.0, 90.0, 180.0}) {
        const Eigen::Matrix3d turn =
            Eigen::AngleAxisd(degrees * std::numbers::pi / 180.0, Eigen::Vector3d::UnitY())
                .toRotationMatrix();
        const Points turned = set.points[0] * turn.transpose();
        const Eigen::Vector3d viewer = automatic_view(faces, turned).row(2).transpose();
        EXPECT_GT(viewer.dot(turn * Eigen::Vector3d::UnitZ()),
                  std::cos(25.0 * std::numbers::pi / 180.0));
    }
}

TEST(AutomaticView, LooksAlongTheThinnestAxisOfClosedSurfaces)
{
    const test::TestMesh ball = test::icosphere(2);
    for (int axis = 0; axis < 3; ++axis) {
        Points flat = ball.points;
        flat.col(axis) *= 0.3;
        const Eigen::Matrix3d view = automatic_view(ball.topology.faces(), flat);
        EXPECT_TRUE(view.row(2).transpose().isApprox(Eigen::Vector3d::Unit(axis), 1e-12));
        EXPECT_NEAR(view.determinant(), 1.0, 1e-12);
    }
    EXPECT_TRUE(automatic_view(ball.topology.faces(), ball.points).isIdentity(1e-12));
}

} // namespace
} // namespace shape
