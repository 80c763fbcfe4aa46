// SPDX-License-Identifier: MIT

#include "libshape/statistics/student_t.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "libshape/base/error.h"

namespace shape {
using namespace internal;
namespace {

constexpr double pi = std::numbers::pi;

TEST(StudentT, HasItsClosedFormsOfFewDegreesOfFreedom)
{
    for (double t = 1e-6; t < 1e6; t *= 1.7) {
        const double root = std::sqrt(2.0 + t * t);
        const double two = 2.0 / (root * (root + t)); // 1 - t / root without cancellation
        EXPECT_NEAR(two_sided_t_probability(t, 1.0) / (2.0 / pi * std::atan2(1.0, t)), 1.0, 1e-12);
        EXPECT_NEAR(two_sided_t_probability(t, 2.0) / two, 1.0, 1e-12) << t;
        if (t < 10.0) {
            const double u = t / std::sqrt(3.0);
            const double three = 2.0 / pi * (std::atan2(1.0, u) - u / (1.0 + u * u));
            EXPECT_NEAR(two_sided_t_probability(t, 3.0) / three, 1.0, 1e-11) << t;
            const double s = t / std::sqrt(4.0 + t * t);
            EXPECT_NEAR(two_sided_t_probability(t, 4.0), 1.0 - 1.5 * s + 0.5 * s * s * s, 1e-13);
        }
    }
}

TEST(StudentT, AgreesWithTheIncompleteBetaFunctionInFortyDigits)
{
    struct
    {
        double t, degrees_of_freedom, probability; // by tests/oracles/student_t.py
    } const published[] = {
        {0.001, 0.5, 0.99946064766848763807},     {0.3, 2.7, 0.78576653269444812203},
        {1.0, 7.5, 0.34847602563075139196},       {2.5, 12.25, 0.027561650181420264543},
        {40.0, 3.5, 8.7664411093730198631e-6},    {6.0, 199.0, 9.178170004044680753e-9},
        {25.0, 199.0, 2.5848168756040164372e-63}, {1.96, 1e4, 0.050023520231833049539},
        {100.0, 50.0, 2.9608988920252441726e-59}};
    for (const auto& [t, degrees_of_freedom, probability] : published)
        EXPECT_NEAR(two_sided_t_probability(t, degrees_of_freedom) / probability, 1.0, 1e-11) << t;
}

TEST(StudentT, KnowsNoSignAndFallsFromOneToZero)
{
    for (const double n : {0.1, 1.5, 8.0, 300.0}) {
        EXPECT_EQ(two_sided_t_probability(0.0, n), 1.0);
        EXPECT_EQ(two_sided_t_probability(std::numeric_limits<double>::infinity(), n), 0.0);
        double before = 1.0;
        for (double t = 0.01; t < 30.0; t *= 1.1) {
            const double p = two_sided_t_probability(t, n);
            EXPECT_LT(p, before);
            EXPECT_EQ(two_sided_t_probability(-t, n), p);
            before = p;
        }
    }
}

TEST(StudentT, TendsToTheNormalDistribution)
{
    for (const double t : {0.5, 1.0, 2.0, 3.0})
        EXPECT_NEAR(two_sided_t_probability(t, 1e6), std::erfc(t / std::sqrt(2.0)), 1e-6);
}

TEST(StudentT, RefusesArgumentsOutOfRange)
{
    EXPECT_THROW((void)two_sided_t_probability(std::nan(""), 1.0), InvalidInput);
    for (const double n : {0.0, -1.0, std::nan(""), std::numeric_limits<double>::infinity()})
        EXPECT_THROW((void)two_sided_t_probability(1.0, n), InvalidInput);
}

} // namespace
} // namespace shape
