// SPDX-License-Identifier: MIT

#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace shape::internal {

/// The channel of sRGB (IEC 61966-2-1) that shows an amount of light; amounts outside [0, 1] count as the nearer end.
inline std::uint8_t srgb_encoded(double linear)
{
    const double c = std::clamp(linear, 0.0, 1.0);
    const double srgb = c <= 0.0031308 ? 12.92 * c : 1.055 * std::pow(c, 1.0 / 2.4) - 0.055;
    return static_cast<std::uint8_t>(std::lround(255.0 * srgb));
}

/// The amount of light in [0, 1] that a channel shows.
inline double srgb_decoded(std::uint8_t channel)
{
    const double c = channel / 255.0;
    return c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4);
}

} // namespace shape::internal
