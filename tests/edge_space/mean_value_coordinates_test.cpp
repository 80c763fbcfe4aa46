// SPDX-License-Identifier: MIT

#include "libshape/edge_space/mean_value_coordinates.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "libshape/base/error.h"
#include "libshape/base/random.h"

namespace shape {
using namespace internal;
namespace {

using Eigen::Vector2d;
using Eigen::VectorXd;

Polygon polygon(std::initializer_list<Vector2d> corners)
{
    Polygon result(static_cast<Eigen::Index>(corners.size()), 2);
    Eigen::Index row = 0;
    for (const Vector2d& corner : corners)
        result.row(row++) = corner.transpose();
    return result;
}

const Polygon square = polygon({{0, 0}, {2, 0}, {2, 2}, {0, 2}});
const Polygon ell = polygon({{0, 0}, {3, 0}, {3, 1}, {1, 1}, {1, 3}, {0, 3}}); // not convex

bool refuses(const Polygon& corners, const Vector2d& point)
{
    try {
        (void)mean_value_coordinates(corners, point);
    } catch (const InvalidInput&) {
        return true;
    }
    return false;
}

/// Seeded points in a box around the polygon that it contains.
std::vector<Vector2d> points_inside(const Polygon& corners, int count, unsigned seed)
{
    Random random(seed);
    std::vector<Vector2d> points;
    while (static_cast<int>(points.size()) < count) {
        const Vector2d point(random.uniform(-0.1, 3.1), random.uniform(-0.1, 3.1));
        if (!refuses(corners, point))
            points.push_back(point);
    }
    return points;
}

TEST(MeanValueCoordinates, CombineTheCornersToThePointAndSumToOne)
{
    for (const Polygon& corners : {square, ell, Polygon(ell.colwise().reverse())})
        for (const Vector2d& point : points_inside(corners, 500, 1)) {
            const VectorXd weights = mean_value_coordinates(corners, point);
            EXPECT_NEAR(weights.sum(), 1.0, 1e-13);
            EXPECT_LT((corners.transpose() * weights - point).norm(), 1e-12);
        }
}

TEST(MeanValueCoordinates, ArePositiveInsideAConvexPolygon)
{
    for (const Vector2d& point : points_inside(square, 500, 2))
        EXPECT_GT(mean_value_coordinates(square, point).minCoeff(), 0.0);
}

TEST(MeanValueCoordinates, OfATriangleAreTheBarycentricOnes)
{
    const Polygon triangle = polygon({{0, 0}, {1, 0}, {0, 1}});
    const VectorXd weights = mean_value_coordinates(triangle, {0.3, 0.2});
    EXPECT_LT((weights - Eigen::Vector3d(0.5, 0.3, 0.2)).norm(), 1e-15);
}

TEST(MeanValueCoordinates, FollowTheFormulaOfTheDefinition)
{
    const Vector2d point(0.5, 0.7);
    VectorXd expected(square.rows());
    const auto angle = [&](Eigen::Index i) {
        const Vector2d a = square.row(i % 4).transpose() - point;
        const Vector2d b = square.row((i + 1) % 4).transpose() - point;
        return std::acos(a.dot(b) / (a.norm() * b.norm()));
    };
    for (Eigen::Index i = 0; i < 4; ++i)
        expected[i] = (std::tan(angle(i + 3) / 2.0) + std::tan(angle(i) / 2.0)) /
                      (square.row(i).transpose() - point).norm();
    expected /= expected.sum();
    EXPECT_LT((mean_value_coordinates(square, point) - expected).norm(), 1e-14);
}

TEST(MeanValueCoordinates, AreExactAtCornersAndLinearOnEdges)
{
    for (Eigen::Index i = 0; i < ell.rows(); ++i) {
        const Vector2d a = ell.row(i).transpose();
        const Vector2d b = ell.row((i + 1) % ell.rows()).transpose();
        EXPECT_EQ(mean_value_coordinates(ell, a), VectorXd::Unit(ell.rows(), i));
        const VectorXd weights = mean_value_coordinates(ell, 0.25 * a + 0.75 * b);
        EXPECT_EQ(weights[i], 0.25);
        EXPECT_EQ(weights[(i + 1) % ell.rows()], 0.75);
        EXPECT_EQ(weights.cwiseAbs().sum(), 1.0);
    }
}

TEST(MeanValueCoordinates, AreContinuousUpToTheBoundary)
{
    for (const double gap : {1e-4, 1e-7, 1e-10}) {
        EXPECT_LT((mean_value_coordinates(square, {0.5, gap}) -
                   mean_value_coordinates(square, {0.5, 0.0}))
                      .norm(),
                  4.0 * gap);
        EXPECT_LT((mean_value_coordinates(ell, {1.0 - gap, 1.0 - gap}) -
                   mean_value_coordinates(ell, {1.0, 1.0}))
                      .norm(),
                  8.0 * gap);
    }
}

TEST(MeanValueCoordinates, AreEqualInTheMiddleOfARegularPolygon)
{
    for (const int n : {3, 5, 8}) {
        const VectorXd weights = mean_value_coordinates(regular_polygon(n), {0.0, 0.0});
        EXPECT_LT((weights.array() - 1.0 / n).abs().maxCoeff(), 1e-15) << n;
    }
}

TEST(MeanValueCoordinates, RefusePointsOutside)
{
    for (const Vector2d& point :
         {Vector2d(2.1, 1.0), Vector2d(-1e-6, 1.0), Vector2d(1.0, 5.0), Vector2d(-1.0, 0.0),
          Vector2d(std::numeric_limits<double>::quiet_NaN(), 1.0)})
        EXPECT_TRUE(refuses(square, point)) << point.transpose();
    EXPECT_TRUE(refuses(ell, {2.0, 2.0})); // in the notch
}

TEST(MeanValueCoordinates, RefusePolygonsThatAreNotSimple)
{
    const double nan = std::numeric_limits<double>::quiet_NaN();
    for (const Polygon& bad : {polygon({{0, 0}, {1, 0}}),                         // two corners
                               polygon({{0, 0}, {2, 2}, {2, 0}, {0, 2}}),         // crossed
                               polygon({{0, 0}, {1, 0}, {1, 1}, {0, 0}}),         // one twice
                               polygon({{0, 0}, {4, 0}, {4, 4}, {2, 0}, {0, 4}}), // touching
                               polygon({{0, 0}, {4, 0}, {2, 0}, {2, 3}}),         // folded back
                               polygon({{0, 0}, {1, 0}, {2, 0}}),                 // no area
                               polygon({{0, 0}, {1, 0}, {nan, 1}})})
        EXPECT_THROW(check_simple_polygon(bad), InvalidInput) << bad;
    EXPECT_NO_THROW(check_simple_polygon(ell));
    EXPECT_THROW((void)regular_polygon(2), InvalidInput);
}

} // namespace
} // namespace shape
