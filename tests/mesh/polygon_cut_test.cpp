// SPDX-License-Identifier: MIT

#include "libshape/mesh/polygon_cut.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "libshape/base/random.h"
#include "libshape/base/to_size.h"
#include "tests/support/meshes.h"

namespace shape::internal {
namespace {

Points polygon(const std::vector<std::array<double, 2>>& corners)
{
    Points points = Points::Zero(std::ssize(corners), 3);
    for (std::size_t i = 0; i < corners.size(); ++i)
        points.row(static_cast<Eigen::Index>(i)) << corners[i][0], corners[i][1], 0.0;
    return points;
}

double area(const Points& points, const std::vector<CutTriangle>& cut)
{
    double sum = 0.0;
    for (const CutTriangle& t : cut) {
        const Eigen::RowVector3d at = points.row(t[0]);
        sum +=
            0.5 * (points.row(t[1]) - at).cross(Eigen::RowVector3d(points.row(t[2]) - at)).norm();
    }
    return sum;
}

const std::vector<std::array<double, 2>> el{{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}};

TEST(PolygonCut, IsTheFanWhereThatDoes)
{
    const Points square = polygon({{0, 0}, {1, 0}, {1, 1}, {0, 1}});
    EXPECT_FALSE(fan_folds_over(square));
    EXPECT_EQ(cut_polygon(square), (std::vector<CutTriangle>{{0, 1, 2}, {0, 2, 3}}));
    // A reflex corner does no harm at the corner of the fan.
    const Points dart = polygon({{0.6, 0.6}, {0, 1}, {0, 0}, {1, 0}});
    EXPECT_EQ(cut_polygon(dart), (std::vector<CutTriangle>{{0, 1, 2}, {0, 2, 3}}));
}

TEST(PolygonCut, CutsConcavePolygonsWithoutFoldsFromEveryCornerAndOnBothSides)
{
    for (std::size_t first = 0; first < el.size(); ++first) {
        std::vector<std::array<double, 2>> corners = el;
        std::rotate(corners.begin(), corners.begin() + static_cast<std::ptrdiff_t>(first),
                    corners.end());
        for (const double size : {1.0, 1e-30, 1e40})
            for (const bool is_reversed : {false, true}) {
                Points points = size * test::moved(polygon(corners), 3);
                if (is_reversed)
                    points = points.colwise().reverse().eval();
                const auto cut = cut_polygon(points);
                ASSERT_TRUE(cut);
                EXPECT_EQ(cut->size(), 4U);
                EXPECT_NEAR(area(points / size, *cut), 3.0, 1e-9) << first;
                EXPECT_FALSE(folds_over(points / size, *cut));
            }
    }
    const Points dart = polygon({{0, 0}, {1, 0}, {0.3, 0.3}, {0, 1}}); // reflex at 2
    EXPECT_FALSE(fan_folds_over(dart));
    const Points turned = polygon({{1, 0}, {0.3, 0.3}, {0, 1}, {0, 0}});
    EXPECT_TRUE(fan_folds_over(turned));
    EXPECT_NEAR(area(turned, cut_polygon(turned).value()), 0.3, 1e-12);
}

TEST(PolygonCut, CutsStarsOfManyCorners)
{
    Random random(4);
    for (const int count : {5, 12, 100, 1024}) {
        Points star = Points::Zero(count, 3);
        double expected = 0.0;
        std::vector<double> radii;
        for (int i = 0; i < count; ++i)
            radii.push_back(random.uniform(0.2, 1.0));
        for (int i = 0; i < count; ++i) {
            const double angle = 2.0 * std::numbers::pi * i / count;
            star.row(i) << radii[to_size(i)] * std::cos(angle), radii[to_size(i)] * std::sin(angle),
                0.0;
            expected += 0.5 * radii[to_size(i)] * radii[to_size((i + 1) % count)] *
                        std::sin(2.0 * std::numbers::pi / count);
        }
        const auto cut = cut_polygon(star);
        ASSERT_TRUE(cut) << count;
        EXPECT_EQ(std::ssize(*cut), count - 2);
        EXPECT_NEAR(area(star, *cut), expected, 1e-9);
        EXPECT_FALSE(folds_over(star, *cut));
    }
}

TEST(PolygonCut, TakesSlitsToHolesAndCornersInALine)
{
    // A square of side 4 with a square hole of side 2, joined by a slit that is run through twice.
    const Points ring =
        polygon({{0, 0}, {4, 0}, {4, 4}, {0, 4}, {0, 0}, {1, 1}, {1, 3}, {3, 3}, {3, 1}, {1, 1}});
    const auto cut = cut_polygon(ring);
    ASSERT_TRUE(cut);
    EXPECT_NEAR(area(ring, *cut), 12.0, 1e-12);
    // From a corner of a straight side the fan has a triangle without area.
    const Points line = polygon({{1, 0}, {2, 0}, {3, 0}, {3, 2}, {0, 2}, {0, 0}});
    const auto fine = cut_polygon(line);
    ASSERT_TRUE(fine);
    EXPECT_FALSE(folds_over(line, *fine));
    EXPECT_NEAR(area(line, *fine), 6.0, 1e-12);
}

TEST(PolygonCut, IsNoneOfWhatCrossesItselfAndTheFanOfWhatHasNoArea)
{
    EXPECT_FALSE(cut_polygon(polygon({{0, 0}, {1, 1}, {1, 0}, {0, 1}})));
    EXPECT_FALSE(cut_polygon(polygon({{0, 0}, {2, 2}, {2, 0}, {0, 1}})));
    const std::vector<CutTriangle> fan{{0, 1, 2}, {0, 2, 3}};
    EXPECT_EQ(cut_polygon(polygon({{0, 0}, {1, 0}, {2, 0}, {3, 0}})), fan);
    EXPECT_EQ(cut_polygon(polygon({{1, 1}, {1, 1}, {1, 1}, {1, 1}})), fan);
    EXPECT_EQ(cut_polygon(polygon({{0, 0}, {1, 0}, {0, 1}, {0, 1}})), fan); // a triangle
}

TEST(PolygonCut, TakesBentPolygons)
{
    Points bent = polygon({{1, 0}, {0.3, 0.3}, {0, 1}, {0, 0}});
    bent.col(2) << 0.1, -0.2, 0.1, 0.2;
    const auto cut = cut_polygon(bent);
    ASSERT_TRUE(cut);
    EXPECT_FALSE(folds_over(bent, *cut));
}

} // namespace
} // namespace shape::internal
