// SPDX-License-Identifier: MIT

#include "libshape/mesh/triangle_area.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>

#include "libshape/base/random.h"

namespace shape {
using namespace internal;
namespace {

/// Any order of the sides must give the same, up to rounding.
void expect_in_any_order(double a, double b, double c, double wanted, double tolerance)
{
    EXPECT_NEAR(sixteen_squared_areas(a, b, c), wanted, tolerance);
    EXPECT_NEAR(sixteen_squared_areas(b, c, a), wanted, tolerance);
    EXPECT_NEAR(sixteen_squared_areas(c, a, b), wanted, tolerance);
    EXPECT_NEAR(sixteen_squared_areas(b, a, c), wanted, tolerance);
}

TEST(TriangleArea, TrianglesWithWholeSidesAndAreaAreExact)
{
    expect_in_any_order(3.0, 4.0, 5.0, 16.0 * 6.0 * 6.0, 0.0);
    expect_in_any_order(13.0, 14.0, 15.0, 16.0 * 84.0 * 84.0, 0.0);
    expect_in_any_order(51.0, 52.0, 101.0, 16.0 * 510.0 * 510.0, 0.0);
}

TEST(TriangleArea, AnEquilateralTriangleHasThreeTimesTheFourthPowerOfItsSideAtAnySize)
{
    for (const double side : {1e-75, 1e-8, 0.7, 1.0, 1e20, 1e75}) {
        const double wanted = 3.0 * side * side * side * side;
        expect_in_any_order(side, side, side, wanted, 12e-16 * wanted);
        EXPECT_TRUE(std::isnormal(wanted));
    }
}

TEST(TriangleArea, IsThatOfTheCornersOfRandomTrianglesWithinTheStatedRounding)
{
    Random random(5);
    for (int i = 0; i < 10000; ++i) {
        // A triangle of exact base and height, flat ones among them.
        const long double base = random.uniform(0.1, 10.0);
        const long double foot = random.uniform(-5.0, 5.0);
        const long double height = std::pow(10.0, random.uniform(-6.0, 1.0));
        const auto a = static_cast<double>(base);
        const auto b = static_cast<double>(std::hypot(foot, height));
        const auto c = static_cast<double>(std::hypot(base - foot, height));
        // Of the sides as they were rounded: by the squares of them, in more digits.
        const long double aa = base * base;
        const long double along =
            (aa + static_cast<long double>(b) * b - static_cast<long double>(c) * c) /
            (2.0L * base);
        const long double up = (b - along) * (b + along);
        const long double wanted = 4.0L * aa * up;
        const double perimeter = a + b + c;
        const double slack = perimeter - 2.0 * std::fmax(a, std::fmax(b, c));
        ASSERT_NEAR(static_cast<double>(sixteen_squared_areas(a, b, c) / wanted), 1.0,
                    4e-16 * perimeter / slack);
    }
}

TEST(TriangleArea, IsZeroWhereASideIsAsLongAsTheOthersTogether)
{
    expect_in_any_order(1.0, 2.0, 3.0, 0.0, 0.0);
    expect_in_any_order(0.1, 0.1, 0.2, 0.0, 0.0);
    expect_in_any_order(1e-75, 1e-75, 2e-75, 0.0, 0.0);
}

TEST(TriangleArea, IsNegativeWhereASideIsLongerThanTheOthersTogether)
{
    expect_in_any_order(1.0, 1.0, 3.0, -45.0, 0.0);
    expect_in_any_order(1.0, 2.0, 4.0, -105.0, 0.0);
    expect_in_any_order(1e-9, 1.0, 2.0, -9.0, 1e-7);
}

TEST(TriangleArea, RoundingNeverTurnsTheSign)
{
    Random random(7);
    int positive = 0, negative = 0;
    for (int i = 0; i < 100000; ++i) {
        // In steps of rounding: sides whose exact sums are whole multiples of one.
        const double unit = std::ldexp(1.0, -52);
        const auto p = static_cast<std::int64_t>(random.index(1ull << 53)) + 1;
        const auto q = static_cast<std::int64_t>(random.index(1ull << 53)) + 1;
        const auto near_sum = p + q + static_cast<std::int64_t>(random.index(9)) - 4;
        const double a = unit * static_cast<double>(p);
        const double b = unit * static_cast<double>(q);
        const double c = unit * static_cast<double>(near_sum);
        const auto exact_c = static_cast<std::int64_t>(c / unit); // even beyond 2^53
        const std::int64_t slack = p + q - exact_c;
        for (const double value : {sixteen_squared_areas(a, b, c), sixteen_squared_areas(b, c, a),
                                   sixteen_squared_areas(c, a, b)}) {
            ASSERT_FALSE(value > 0.0 && slack <= 0) << a << ' ' << b << ' ' << c;
            ASSERT_FALSE(value < 0.0 && slack >= 0) << a << ' ' << b << ' ' << c;
            positive += value > 0.0 ? 1 : 0;
            negative += value < 0.0 ? 1 : 0;
        }
    }
    EXPECT_GT(positive, 1000);
    EXPECT_GT(negative, 1000);
}

} // namespace
} // namespace shape
