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

inline constexpr std::array<UnitRatio, 7> unit_ratios = {{{2.54, "centimetres and inches"},
                                                          {10.0, "millimetres and centimetres"},
                                                          {25.4, "millimetres and inches"},
                                                          {1.0 / 0.0254, "inches and metres"},
                                                          {100.0, "centimetres and metres"},
                                                          {304.8, "millimetres and feet"},
                                                          {1000.0, "millimetres and metres"}}};

/// The units whose ratio lies within a factor of 1.25 of the given one, which sizes of specimens of
/// one kind seldom reach; none if there are none.
/// @param ratio  > 0.
inline std::optional<UnitRatio> unit_ratio_near(double ratio)
{
    for (const UnitRatio& units : unit_ratios)
        for (const double exact : {units.value, 1.0 / units.value})
            if (std::abs(std::log(ratio / exact)) < std::log(1.25))
                return UnitRatio{exact, units.units};
    return std::nullopt;
}

} // namespace shape::internal
