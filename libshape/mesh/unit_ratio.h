// SPDX-License-Identifier: MIT

#pragma once

#include <array>
#include <cmath>
#include <optional>

namespace shape::internal {

/// How many of one unit of length another one is.
struct UnitRatio
{
    double value; ///< Below 1 where the second of the units is the smaller one.
    const char* units;
};

inline constexpr std::array<UnitRatio, 10> unit_ratios = {{{2.54, "centimetres and inches"},
                                                           {1.0 / 0.3048, "feet and metres"},
                                                           {10.0, "millimetres and centimetres"},
                                                           {12.0, "inches and feet"},
                                                           {25.4, "millimetres and inches"},
                                                           {30.48, "centimetres and feet"},
                                                           {1.0 / 0.0254, "inches and metres"},
                                                           {100.0, "centimetres and metres"},
                                                           {304.8, "millimetres and feet"},
                                                           {1000.0, "millimetres and metres"}}};

/// The units whose ratio is nearest to the given one and lies within a factor of 1.25 of it, which sizes of
/// specimens of one kind seldom reach; none if there are none.
/// @param ratio  > 0.
inline std::optional<UnitRatio> unit_ratio_near(double ratio)
{
    std::optional<UnitRatio> found;
    double nearest = std::log(1.25);
    for (const UnitRatio& units : unit_ratios)
        for (const double exact : {units.value, 1.0 / units.value})
            if (const double distance = std::abs(std::log(ratio / exact)); distance < nearest) {
                nearest = distance;
                found = UnitRatio{exact, units.units};
            }
    return found;
}

} // namespace shape::internal
