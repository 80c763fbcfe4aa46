// SPDX-License-Identifier: MIT

#include "libshape/base/vector_math.h"

#include <cmath>
#include <numbers>

#include "libshape/base/vectorised.h"

namespace shape::internal {

// Each loop takes values from arrays that lie side by side and puts results into others,
//
//     angles   t0 t1 t2 t3 | t4 ..      sines   s0 s1 s2 s3 | s4 ..      cosines   c0 c1 c2 c3 | c4 ..
//
// two or four (floats: four or eight) at once. The plain loop calls the standard library's function value by
// value: its branches and tables keep it in one lane. So there is no branch here, every choice is a choice
// of registers, and one polynomial serves the whole range after its reduction:
//
//     sines_cosines    t - 2 pi n, by 4: sine and cosine by Taylor, doubled twice     (|t| <= pi / 4)
//     vector_angles    octant by comparisons, then atan(r) = r + r^3 p(r^2)            (|r| <= tan(pi / 8))

SHAPE_VECTORISED void sines_cosines(const double* angles, std::size_t count, double* sines,
                                    double* cosines)
{
    constexpr double turn = 2.0 * std::numbers::pi;
    constexpr double turn_low = 2.4492935982947064e-16; // 2 pi - turn
    constexpr double round = 0x1.8p52;                  // (x + round) - round is x to the nearest
    for (std::size_t i = 0; i < count; ++i) {
        const double turns = (angles[i] * (1.0 / turn) + round) - round;
        const double q = 0.25 * ((angles[i] - turns * turn) - turns * turn_low);
        const double t = q * q; // q in [-pi/4, pi/4]: Taylor to q^15 and q^16
        double s = -1.0 / 1307674368000.0;
        s = s * t + 1.0 / 6227020800.0;
        s = s * t - 1.0 / 39916800.0;
        s = s * t + 1.0 / 362880.0;
        s = s * t - 1.0 / 5040.0;
        s = s * t + 1.0 / 120.0;
        s = s * t - 1.0 / 6.0;
        s = s * t * q + q;
        double c = 1.0 / 20922789888000.0;
        c = c * t - 1.0 / 87178291200.0;
        c = c * t + 1.0 / 479001600.0;
        c = c * t - 1.0 / 3628800.0;
        c = c * t + 1.0 / 40320.0;
        c = c * t - 1.0 / 720.0;
        c = c * t + 1.0 / 24.0;
        c = c * t - 0.5;
        c = c * t + 1.0;
        const double s2 = 2.0 * s * c; // the angle doubled twice
        const double c2 = 1.0 - 2.0 * s * s;
        sines[i] = 2.0 * s2 * c2;
        cosines[i] = 1.0 - 2.0 * s2 * s2;
    }
}

SHAPE_VECTORISED void vector_angles(const double* y, const double* x, std::size_t count,
                                    double* angles)
{
    constexpr double pi = std::numbers::pi;
    constexpr double octant = 0.41421356237309503; // tan(pi / 8)
    constexpr double smallest = 0x1p-1022;         // keeps 0 / 0 out
    for (std::size_t i = 0; i < count; ++i) {
        const double ax = std::abs(x[i]);
        const double ay = std::abs(y[i]);
        const double low = ax < ay ? ax : ay;
        const double high = ax < ay ? ay : ax;
        // atan(low / high), by atan(r) = pi/4 + atan((r - 1) / (r + 1)) in the upper half.
        const bool upper = low > octant * high;
        const double numerator = upper ? low - high : low;
        const double denominator = upper ? low + high : high;
        const double r = numerator / (denominator + smallest);
        const double t = r * r; // atan(r) / r - 1 over t, through 11 Chebyshev points: 5e-18
        double p = -0.01917688711906226;
        p = p * t + 0.03923165829558719;
        p = p * t - 0.0508544973794026;
        p = p * t + 0.0585814891280221;
        p = p * t - 0.06664511447381948;
        p = p * t + 0.07692183190826087;
        p = p * t - 0.09090904578123903;
        p = p * t + 0.11111111015256361;
        p = p * t - 0.14285714284666542;
        p = p * t + 0.1999999999999552;
        p = p * t - 1.0 / 3.0;
        double angle = r + r * t * p;
        angle = upper ? angle + 0.25 * pi : angle;
        angle = ax < ay ? 0.5 * pi - angle : angle;
        angle = x[i] < 0.0 ? pi - angle : angle;
        angles[i] = y[i] < 0.0 ? -angle : angle;
    }
}

SHAPE_VECTORISED void vector_angles(const float* y, const float* x, std::size_t count,
                                    float* angles)
{
    constexpr float pi = std::numbers::pi_v<float>;
    constexpr float octant = 0.41421356F; // tan(pi / 8)
    constexpr float smallest = 0x1p-126F; // keeps 0 / 0 out
    for (std::size_t i = 0; i < count; ++i) {
        const float ax = std::abs(x[i]);
        const float ay = std::abs(y[i]);
        const float low = ax < ay ? ax : ay;
        const float high = ax < ay ? ay : ax;
        const bool upper = low > octant * high; // as above
        const float numerator = upper ? low - high : low;
        const float denominator = upper ? low + high : high;
        const float r = numerator / (denominator + smallest);
        const float t = r * r; // through 4 Chebyshev points: 8e-8
        float p = 0.0852049204F;
        p = p * t - 0.140241428F;
        p = p * t + 0.199912377F;
        p = p * t - 0.333332866F;
        float angle = r + r * t * p;
        angle = upper ? angle + 0.25F * pi : angle;
        angle = ax < ay ? 0.5F * pi - angle : angle;
        angle = x[i] < 0.0F ? pi - angle : angle;
        angles[i] = y[i] < 0.0F ? -angle : angle;
    }
}

} // namespace shape::internal
