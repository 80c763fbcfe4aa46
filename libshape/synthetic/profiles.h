// SPDX-License-Identifier: MIT

#pragma once

#include <algorithm>
#include <cmath>

/// The two smooth functions of one variable that the synthetic shapes are sculpted with.
namespace shape::internal::synthetic {

/// Gaussian of height 1 and standard deviation `width`.
[[nodiscard]] inline double bump(double x, double centre, double width)
{
    const double t = (x - centre) / width;
    return std::exp(-0.5 * t * t);
}

/// 0 below low, 1 above high, a cubic with level ends between.
[[nodiscard]] inline double ramp(double x, double low, double high)
{
    const double t = std::clamp((x - low) / (high - low), 0.0, 1.0);
    return t * t * (3.0 - 2.0 * t);
}

} // namespace shape::internal::synthetic
