// SPDX-License-Identifier: MIT

#include "libshape/mesh/coordinate_spacing.h"

#include <algorithm>
#include <cmath>

namespace shape::internal {
namespace {

bool is_single_precision(const Points& points)
{
    const auto coordinates = points.reshaped();
    return std::all_of(coordinates.begin(), coordinates.end(),
                       [](double x) { return static_cast<double>(static_cast<float>(x)) == x; });
}

/// The exponent of ten.
double decade_of(double x)
{
    return std::floor(std::log10(x));
}

/// Whether a number is one of so many significant digits, up to the rounding of its format.
/// @param x  > 0. @param rounding  Of the format, relative.
bool has_digits(double x, int digits, double rounding)
{
    const double scaled = x * std::pow(10.0, digits - 1 - decade_of(x));
    return std::abs(scaled - std::round(scaled)) <= rounding * scaled;
}

} // namespace

double coordinate_spacing(const Points& points)
{
    const double largest = points.rows() == 0 ? 0.0 : points.cwiseAbs().maxCoeff();
    if (!(largest > 0.0))
        return 0.0;
    const bool is_single = is_single_precision(points);
    int exponent = 0;
    (void)std::frexp(largest, &exponent);
    const double binary = std::ldexp(1.0, exponent - (is_single ? 24 : 53));

    // Of more digits than `most`, single precision holds nearly all numbers and double precision so many that they
    // matter to nobody.
    const int most = is_single ? 6 : 9;
    const double rounding = is_single ? 6e-8 : 1e-15;
    int digits = 4; // of fewer, as small integers have, nobody writes coordinates
    for (const double coordinate : points.reshaped()) {
        const double x = std::abs(coordinate);
        if (x < 1e-9 * largest)
            continue;
        while (!has_digits(x, digits, rounding))
            if (++digits > most)
                return binary;
    }
    return std::max(binary, std::pow(10.0, decade_of(largest) + 1 - digits));
}

} // namespace shape::internal
