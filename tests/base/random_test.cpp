// SPDX-License-Identifier: MIT

#include "libshape/base/random.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

namespace shape {
using namespace internal;
namespace {

TEST(Random, GivesThePublishedNumbersOfSplitMix64)
{
    // Output of the reference implementation (Vigna, splitmix64.c) for this seed.
    Random random(1234567);
    for (const std::uint64_t expected :
         {6457827717110365317ULL, 3203168211198807973ULL, 9817491932198370423ULL,
          4593380528125082431ULL, 16408922859458223821ULL})
        EXPECT_EQ(random.bits(), expected);
}

TEST(Random, GivesThePublishedCountsOfFiveClasses)
{
    // rosettacode.org, "Pseudo-random numbers/Splitmix64": 100,000 draws from 0 to 4.
    Random random(987654321);
    std::array<int, 5> counts{};
    for (int i = 0; i < 100000; ++i)
        ++counts[random.index(5)];
    EXPECT_EQ(counts, (std::array<int, 5>{20027, 19892, 20073, 19978, 20030}));
}

TEST(Random, RepeatsItselfFromTheSameSeedAndFromNoOther)
{
    Random a(7);
    Random b(7);
    Random c(8);
    int equal = 0;
    for (int i = 0; i < 100; ++i) {
        const std::uint64_t bits = a.bits();
        EXPECT_EQ(bits, b.bits());
        equal += bits == c.bits();
    }
    EXPECT_EQ(equal, 0);
}

TEST(Random, StaysInsideTheRangesThatAreAskedFor)
{
    Random random(3);
    for (int i = 0; i < 10000; ++i) {
        const double u = random.uniform();
        EXPECT_TRUE(u >= 0.0 && u < 1.0) << u;
        const double x = random.uniform(-3.0, -2.0);
        EXPECT_TRUE(x >= -3.0 && x < -2.0) << x;
        EXPECT_LT(random.index(3), 3u);
        EXPECT_EQ(random.index(1), 0u);
    }
}

TEST(Random, HasTheMomentsOfItsDistributions)
{
    Random random(11);
    const int count = 200000;
    double uniform_mean = 0.0;
    double uniform_square = 0.0;
    std::array<double, 4> normal{};
    for (int i = 0; i < count; ++i) {
        const double u = random.uniform();
        uniform_mean += u / count;
        uniform_square += u * u / count;
        const double x = random.normal();
        for (std::size_t power = 0; power < normal.size(); ++power)
            normal[power] += std::pow(x, static_cast<double>(power + 1)) / count;
    }
    // Five standard deviations of each estimate.
    const double five = 5.0 / std::sqrt(count);
    EXPECT_NEAR(uniform_mean, 0.5, five * std::sqrt(1.0 / 12.0));
    EXPECT_NEAR(uniform_square, 1.0 / 3.0, five * std::sqrt(4.0 / 45.0));
    EXPECT_NEAR(normal[0], 0.0, five);
    EXPECT_NEAR(normal[1], 1.0, five * std::sqrt(2.0));
    EXPECT_NEAR(normal[2], 0.0, five * std::sqrt(15.0));
    EXPECT_NEAR(normal[3], 3.0, five * std::sqrt(96.0));
}

} // namespace
} // namespace shape
