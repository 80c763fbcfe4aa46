// SPDX-License-Identifier: MIT

#include "libshape/mesh/keyframes.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>

#include "libshape/base/error.h"
#include "libshape/base/to_size.h"
#include "tests/support/files.h"
#include "tests/support/matrices.h"

namespace shape {
using namespace internal;
namespace {

using Indices = std::vector<std::size_t>;

/// Frames of one point at (x(k), 0, 0).
template <class Function>
std::vector<Points> moving_point(int count, const Function& x)
{
    std::vector<Points> frames;
    for (int k = 0; k < count; ++k)
        frames.emplace_back(Points::Zero(1, 3))(0, 0) = x(k);
    return frames;
}

/// Seeded walks of a few points that turn at every frame.
std::vector<Points> random_walk(int count, unsigned seed)
{
    std::vector<Points> frames{test::random_matrix(4, 3, seed)};
    while (static_cast<int>(frames.size()) < count)
        frames.push_back(
            frames.back() +
            Points(test::random_matrix(4, 3, 100 * seed + static_cast<unsigned>(frames.size()))));
    return frames;
}

/// The largest error of a coordinate of frames between neighbouring keyframes.
double error_of(const std::vector<Points>& frames, const Indices& keyframes)
{
    double error = 0.0;
    for (std::size_t n = 1; n < keyframes.size(); ++n) {
        const std::size_t a = keyframes[n - 1];
        const std::size_t b = keyframes[n];
        for (std::size_t k = a; k <= b; ++k) {
            const double t = static_cast<double>(k - a) / static_cast<double>(b - a);
            const Points made = (1.0 - t) * frames[a] + t * frames[b];
            error = std::max(error, (made - frames[k]).cwiseAbs().maxCoeff());
        }
    }
    return error;
}

TEST(Keyframes, OfALinearMotionAreItsEnds)
{
    const auto frames = moving_point(50, [](int k) { return 0.3 * k - 2.0; });
    const Keyframes keyframes = choose_keyframes(frames, 1e-9);
    EXPECT_EQ(keyframes.frames, (Indices{0, 49}));
    EXPECT_LE(keyframes.error, 1e-13);
}

TEST(Keyframes, OfAPolygonalMotionAreItsCorners)
{
    const auto frames = moving_point(21, [](int k) { return k < 7 ? k : k < 12 ? 7 : 19 - k; });
    EXPECT_EQ(choose_keyframes(frames, 1e-9).frames, (Indices{0, 7, 12, 20}));
}

TEST(Keyframes, OfAParabolaAreAsFewAsItsCurvatureAllows)
{
    // Between keyframes L frames apart, c k^2 differs from its chord by at most c floor(L^2 / 4).
    const auto frames = moving_point(101, [](int k) { return 0.01 * k * k; });
    for (const int reach : {1, 2, 3, 5, 8, 20}) {
        const double tolerance = 0.01 * (reach * reach / 4) + 1e-9;
        const Keyframes keyframes = choose_keyframes(frames, tolerance);
        EXPECT_EQ(keyframes.frames.size(), to_size((100 + reach - 1) / reach + 1));
        EXPECT_LE(keyframes.error, tolerance);
    }
}

TEST(Keyframes, AreTheFewestOfAllSubsets)
{
    for (unsigned seed = 1; seed <= 20; ++seed)
        for (const double tolerance : {0.2, 0.6, 1.5}) {
            const std::vector<Points> frames = random_walk(9, seed);
            int fewest = 9;
            for (unsigned inner = 0; inner < 128; ++inner) {
                Indices subset{0};
                for (std::size_t k = 1; k < 8; ++k)
                    if ((inner >> (k - 1)) % 2 == 1)
                        subset.push_back(k);
                subset.push_back(8);
                if (error_of(frames, subset) <= tolerance)
                    fewest = std::min(fewest, std::popcount(inner) + 2);
            }
            const Keyframes keyframes = choose_keyframes(frames, tolerance);
            EXPECT_EQ(keyframes.frames.size(), to_size(fewest)) << seed;
            EXPECT_NEAR(keyframes.error, error_of(frames, keyframes.frames), 1e-13);
            EXPECT_LE(keyframes.error, tolerance * (1.0 + 1e-12));
        }
}

TEST(Keyframes, AreAllFramesOfACurvedMotionWithoutTolerance)
{
    EXPECT_EQ(choose_keyframes(random_walk(12, 3), 0.0).frames.size(), 12U);
}

TEST(Keyframes, OfAStillSequenceAreItsEnds)
{
    const auto frames = moving_point(30, [](int) { return 0.1; });
    EXPECT_EQ(choose_keyframes(frames, 0.0).frames, (Indices{0, 29}));
}

TEST(Keyframes, OfASingleFrameAreThatFrame)
{
    EXPECT_EQ(choose_keyframes(random_walk(1, 1), 0.0).frames, (Indices{0}));
}

TEST(Keyframes, RefuseWhatIsNotASequence)
{
    const auto message = [](const std::vector<Points>& frames, double tolerance) {
        return test::message_of<InvalidInput>([&] { (void)choose_keyframes(frames, tolerance); });
    };
    EXPECT_NE(message({}, 1.0).find("empty"), std::string::npos);
    EXPECT_NE(message({Points::Zero(2, 3), Points::Zero(3, 3)}, 1.0).find("frames[1]"),
              std::string::npos);
    EXPECT_NE(message({Points::Constant(2, 3, std::nan(""))}, 1.0).find("finite"),
              std::string::npos);
    for (const double tolerance : {-1.0, std::nan("")})
        EXPECT_NE(message({Points::Zero(2, 3)}, tolerance).find("tolerance"), std::string::npos);
}

} // namespace
} // namespace shape
