// SPDX-License-Identifier: MIT

#include "libshape/mesh/coordinate_spacing.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "tests/support/meshes.h"

namespace shape {
using namespace internal;
namespace {

/// A sphere around a place as scanners have it: the largest coordinate is between 512 and 1000.
Points sphere()
{
    return (8.0 * test::bumpy_sphere(2, 0.1, 1).points).rowwise() +
           Eigen::RowVector3d(150.0, -220.0, 900.0);
}

Points printed(Points points, const char* format)
{
    for (double& x : points.reshaped()) {
        char text[64];
        std::snprintf(text, sizeof text, format, x);
        x = std::strtod(text, nullptr);
    }
    return points;
}

TEST(CoordinateSpacing, IsThatOfTheFormatThatHoldsAll)
{
    EXPECT_EQ(coordinate_spacing(sphere()), std::ldexp(1.0, -43));
    EXPECT_EQ(coordinate_spacing(sphere().cast<float>().cast<double>()), std::ldexp(1.0, -14));
    EXPECT_NEAR(coordinate_spacing(printed(sphere(), "%.4f")), 1e-4, 1e-12);
    EXPECT_NEAR(coordinate_spacing(printed(sphere(), "%.6g")), 1e-3, 1e-12);
    EXPECT_NEAR(coordinate_spacing(printed(sphere(), "%.6e")), 1e-4, 1e-12);
    EXPECT_NEAR(coordinate_spacing(1e-9 * printed(sphere(), "%.6g")), 1e-12, 1e-20);
    // Text of seven digits that became single precision is no coarser than that.
    EXPECT_NEAR(coordinate_spacing(printed(sphere(), "%.5g").cast<float>().cast<double>()), 1e-2,
                1e-10);
    EXPECT_EQ(coordinate_spacing(printed(sphere(), "%.7g").cast<float>().cast<double>()),
              std::ldexp(1.0, -14));
}

TEST(CoordinateSpacing, OneFineNumberTellsAndWhatIsRoundingDoesNot)
{
    Points points = printed(sphere(), "%.4f");
    points(40, 1) = 1.2345678901234e-13;
    EXPECT_NEAR(coordinate_spacing(points), 1e-4, 1e-12);
    points(40, 1) = 1.0 / 3.0;
    EXPECT_EQ(coordinate_spacing(points), std::ldexp(1.0, -43));
}

TEST(CoordinateSpacing, SmallIntegersHaveFourDigitsAndNothingHasNone)
{
    EXPECT_NEAR(coordinate_spacing(test::tetrahedron().points), 1e-3, 1e-15);
    EXPECT_EQ(coordinate_spacing(Points::Zero(3, 3)), 0.0);
    EXPECT_EQ(coordinate_spacing(Points(0, 3)), 0.0);
}

} // namespace
} // namespace shape
