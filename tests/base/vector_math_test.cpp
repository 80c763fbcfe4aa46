// SPDX-License-Identifier: MIT

#include "libshape/base/vector_math.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "libshape/base/random.h"

namespace shape {
using namespace internal;
namespace {

constexpr double pi = std::numbers::pi;

TEST(SinesCosines, AreThoseOfTheStandardLibrary)
{
    Random random(1);
    std::vector<double> angles{0.0, -0.0, pi, -pi, 0.5 * pi, 1e-300, 1e-9, 1e5};
    for (int i = 0; i < 10000; ++i)
        angles.push_back(random.uniform(-20.0, 20.0));
    std::vector<double> sines(angles.size());
    std::vector<double> cosines(angles.size());
    sines_cosines(angles.data(), angles.size(), sines.data(), cosines.data());
    for (std::size_t i = 0; i < angles.size(); ++i) {
        const double tolerance = 1e-15 + 1e-16 * std::abs(angles[i]);
        EXPECT_NEAR(sines[i], std::sin(angles[i]), tolerance) << angles[i];
        EXPECT_NEAR(cosines[i], std::cos(angles[i]), tolerance) << angles[i];
    }
}

TEST(VectorAngles, AreThoseOfTheStandardLibrary)
{
    Random random(2);
    std::vector<double> y{0.0, 0.0, 1.0, -1.0, 0.0, 1e-200, 1e-9, -1e-9, 1e200, 1e-310, 5e-324};
    std::vector<double> x{0.0, 1.0, 0.0, 0.0, -1.0, 1e-200, 1.0, -1.0, 1e190, 1.0, 1.0};
    for (int i = 0; i < 20000; ++i) {
        const double size = std::exp(random.uniform(-50.0, 50.0));
        y.push_back(size * random.uniform(-1.0, 1.0));
        x.push_back(size * random.uniform(-1.0, 1.0) * (i % 2 == 0 ? 1.0 : 1e-6));
    }
    std::vector<double> angles(y.size());
    vector_angles(y.data(), x.data(), y.size(), angles.data());
    for (std::size_t i = 0; i < y.size(); ++i) {
        const double expected = std::atan2(y[i], x[i]);
        EXPECT_NEAR(angles[i], expected, 1e-15 * std::abs(expected)) << y[i] << ' ' << x[i];
    }
}

TEST(VectorAngles, AreThoseOfTheStandardLibraryInSinglePrecision)
{
    Random random(3);
    std::vector<float> y{0.0F, 0.0F, 1.0F, -1.0F, 0.0F, 1e-20F, 1e-9F, -1e-9F, 1e30F, 1e-40F};
    std::vector<float> x{0.0F, 1.0F, 0.0F, 0.0F, -1.0F, 1e-20F, 1.0F, -1.0F, 1e20F, 1.0F};
    for (int i = 0; i < 20000; ++i) {
        const double size = std::exp(random.uniform(-20.0, 20.0));
        y.push_back(static_cast<float>(size * random.uniform(-1.0, 1.0)));
        x.push_back(static_cast<float>(size * random.uniform(-1.0, 1.0) * (i % 2 == 0 ? 1 : 1e-6)));
    }
    std::vector<float> angles(y.size());
    vector_angles(y.data(), x.data(), y.size(), angles.data());
    for (std::size_t i = 0; i < y.size(); ++i) {
        const float expected = std::atan2(y[i], x[i]);
        EXPECT_NEAR(angles[i], expected, 3e-7F * std::abs(expected)) << y[i] << ' ' << x[i];
    }
}

TEST(VectorMath, GivesAValueTheSameBitsWhereverItStands)
{
    const std::vector<double> y(37, 0.7312);
    const std::vector<double> x(37, -1.9);
    std::vector<double> first(37);
    std::vector<double> second(37);
    sines_cosines(y.data(), y.size(), first.data(), second.data());
    for (std::size_t i = 0; i < y.size(); ++i) {
        EXPECT_EQ(first[i], first[0]);
        EXPECT_EQ(second[i], second[0]);
    }
    vector_angles(y.data(), x.data(), y.size(), first.data());
    for (const double angle : first)
        EXPECT_EQ(angle, first[0]);
}

} // namespace
} // namespace shape
