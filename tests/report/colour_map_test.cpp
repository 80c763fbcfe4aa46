// SPDX-License-Identifier: MIT

#include "libshape/report/colour_map.h"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>
#include <limits>

namespace shape {
namespace {

double linear(std::uint8_t channel)
{
    const double c = channel / 255.0;
    return c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4);
}

/// CIE 1976 L*, the older measure of lightness: another formula than the maps are made with.
double lightness(Colour c)
{
    const double y = 0.2126 * linear(c.red) + 0.7152 * linear(c.green) + 0.0722 * linear(c.blue);
    return y > 0.008856 ? 116.0 * std::cbrt(y) - 16.0 : 903.3 * y;
}

/// Simulated brightness for people without the red cones would be darker; blue against red must
/// differ in hue that every dichromat sees: in blue minus the rest.
double blueness(Colour c)
{
    return c.blue - 0.5 * (c.red + c.green);
}

TEST(ColourMap, SequentialLightnessRisesEvenly)
{
    const double first = lightness(map_colour(ColourMap::Sequential, 0.0));
    const double last = lightness(map_colour(ColourMap::Sequential, 1.0));
    EXPECT_LT(first, 30.0);
    EXPECT_GT(last, 88.0);
    for (int i = 0; i <= 20; ++i) {
        const double t = i / 20.0;
        EXPECT_NEAR(lightness(map_colour(ColourMap::Sequential, t)), first + t * (last - first),
                    6.0);
    }
}

TEST(ColourMap, DivergingIsEquallyLightOnBothSidesAndBlueAgainstRed)
{
    for (int i = 0; i <= 10; ++i) {
        const Colour low = map_colour(ColourMap::Diverging, 0.5 - 0.05 * i);
        const Colour high = map_colour(ColourMap::Diverging, 0.5 + 0.05 * i);
        EXPECT_NEAR(lightness(low), lightness(high), 6.0);
        if (i > 1) {
            EXPECT_GT(blueness(low), blueness(high) + 8.0 * i);
        }
    }
    const Colour middle = map_colour(ColourMap::Diverging, 0.5);
    EXPECT_EQ(middle.red, middle.green);
    EXPECT_EQ(middle.green, middle.blue);
}

TEST(ColourMap, ClampsAndShowsWhatIsNotANumberAsGrey)
{
    for (const ColourMap map : {ColourMap::Sequential, ColourMap::Diverging}) {
        EXPECT_EQ(map_colour(map, -3.0), map_colour(map, 0.0));
        EXPECT_EQ(map_colour(map, 7.0), map_colour(map, 1.0));
        EXPECT_EQ(map_colour(map, std::numeric_limits<double>::quiet_NaN()),
                  (Colour{128, 128, 128}));
    }
}

TEST(CategoryColour, SixDifferThenRepeat)
{
    for (std::size_t i = 0; i < 6; ++i) {
        EXPECT_EQ(category_colour(i), category_colour(i + 6));
        for (std::size_t j = 0; j < i; ++j)
            EXPECT_NE(category_colour(i), category_colour(j));
    }
}

} // namespace
} // namespace shape
