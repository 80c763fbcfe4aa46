// SPDX-License-Identifier: MIT

#include "libshape/report/colour_map.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "libshape/report/srgb.h"

namespace shape {
using namespace internal;
namespace {

/// Oklab to sRGB.
Colour from_oklab(double lightness, double a, double b)
{
    const double l = std::pow(lightness + 0.3963377774 * a + 0.2158037573 * b, 3);
    const double m = std::pow(lightness - 0.1055613458 * a - 0.0638541728 * b, 3);
    const double s = std::pow(lightness - 0.0894841775 * a - 1.2914855480 * b, 3);
    return {srgb_encoded(4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s),
            srgb_encoded(-1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s),
            srgb_encoded(-0.0041960863 * l - 0.7034186147 * m + 1.7076147010 * s)};
}

} // namespace

Colour map_colour(ColourMap map, double value)
{
    if (std::isnan(value))
        return {128, 128, 128};
    const double t = std::clamp(value, 0.0, 1.0);
    if (map == ColourMap::Diverging) {
        // Lightness falls linearly from the middle; hue is blue (250 deg) or red (30 deg).
        const double away = std::abs(2.0 * t - 1.0);
        const double hue = (t < 0.5 ? 250.0 : 30.0) * std::numbers::pi / 180.0;
        const double chroma = 0.16 * away;
        return from_oklab(0.95 - 0.43 * away, chroma * std::cos(hue), chroma * std::sin(hue));
    }
    // Lightness and hue rise linearly from dark blue (280 deg) over green to yellow (105 deg).
    const double hue = (280.0 - 175.0 * t) * std::numbers::pi / 180.0;
    const double chroma = 0.11 + 0.03 * t;
    return from_oklab(0.28 + 0.66 * t, chroma * std::cos(hue), chroma * std::sin(hue));
}

Colour category_colour(std::size_t category)
{
    static constexpr std::array<Colour, 6> colours{{{0, 114, 178},
                                                    {213, 94, 0},
                                                    {0, 158, 115},
                                                    {204, 121, 167},
                                                    {230, 159, 0},
                                                    {86, 180, 233}}};
    return colours[category % colours.size()];
}

} // namespace shape
