// SPDX-License-Identifier: MIT

#include "libshape/statistics/student_t.h"

#include <cmath>
#include <limits>

#include "libshape/base/error.h"
#include "libshape/base/format.h"

namespace shape::internal {
namespace {

/// 1 / (1 + d_1 / (1 + d_2 / (1 + ...))) of DLMF 8.17.22 by the modified Lentz algorithm; converges
/// fast for x < (a + 1) / (a + b + 2).
double beta_fraction(double a, double b, double x)
{
    constexpr double tiny =
        1e-300; // takes the place of a denominator of 0, as Lentz's method has it
    constexpr int most_terms = 10'000;
    const auto not_zero = [](double value) { return value == 0.0 ? tiny : value; };
    double upper = 1.0;
    double lower = 0.0;
    double result = 1.0;
    for (int j = 1; j <= most_terms; ++j) {
        const int half = j / 2; // rounded down
        const double m = half;
        const double d = j % 2 == 0
                             ? m * (b - m) * x / ((a + 2.0 * m - 1.0) * (a + 2.0 * m))
                             : -(a + m) * (a + b + m) * x / ((a + 2.0 * m) * (a + 2.0 * m + 1.0));
        lower = 1.0 / not_zero(1.0 + d * lower);
        upper = not_zero(1.0 + d / upper);
        result *= upper * lower;
        if (std::abs(upper * lower - 1.0) <= std::numeric_limits<double>::epsilon())
            break;
    }
    return 1.0 / result;
}

} // namespace

double two_sided_t_probability(double t, double degrees_of_freedom)
{
    if (std::isnan(t))
        throw InvalidInput("t is NaN");
    if (!(degrees_of_freedom > 0.0 && std::isfinite(degrees_of_freedom)))
        throw InvalidInput(
            join("degrees_of_freedom is ", degrees_of_freedom, ", must be > 0 and finite"));
    if (std::isinf(t))
        return 0.0;
    if (t == 0.0)
        return 1.0;
    const double a = 0.5 * degrees_of_freedom;
    const double b = 0.5;
    const double ratio = t * (t / degrees_of_freedom);
    const double log_x = -std::log1p(ratio);
    const double log_rest = -std::log1p(1.0 / ratio); // of 1 - x
    const double log_beta = std::lgamma(a) + std::lgamma(b) - std::lgamma(a + b);
    const double factor = std::exp(a * log_x + b * log_rest - log_beta);
    const double x = 1.0 / (1.0 + ratio);
    if (x < (a + 1.0) / (a + b + 2.0))
        return factor / a * beta_fraction(a, b, x);
    return 1.0 - factor / b * beta_fraction(b, a, ratio / (1.0 + ratio));
}

} // namespace shape::internal
