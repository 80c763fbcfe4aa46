// SPDX-License-Identifier: MIT

#include "libshape/edge_space/paths.h"

#include <gtest/gtest.h>

#include <functional>
#include <limits>

#include "libshape/base/error.h"
#include "libshape/base/random.h"

namespace shape {
using namespace internal;
namespace {

using Eigen::VectorXd;

const double nan = std::numeric_limits<double>::quiet_NaN();

VectorXd uniform_knots(int count)
{
    return VectorXd::LinSpaced(count, 0.0, count - 1.0);
}

/// Central differences of a path at t.
VectorXd slope(const std::function<VectorXd(double)>& path, double t, double step = 1e-6)
{
    return (path(t + step) - path(t - step)) / (2.0 * step);
}

TEST(Paths, WeightsSumToOne)
{
    Random random(1);
    for (int n = 2; n <= 9; ++n)
        for (int i = 0; i < 100; ++i) {
            const double t = random.uniform();
            EXPECT_NEAR(line_weights(n, random.uniform(-3.0, 3.0)).sum(), 1.0, 1e-13);
            EXPECT_NEAR(catmull_rom_weights(uniform_knots(n), t * (n - 1)).sum(), 1.0, 1e-13);
            EXPECT_NEAR(b_spline_weights(n, t).sum(), 1.0, 1e-13);
            EXPECT_GE(b_spline_weights(n, t).minCoeff(), 0.0);
            EXPECT_NEAR(bilinear_weights(random.normal(), random.normal()).sum(), 1.0, 1e-12);
        }
}

TEST(LineWeights, MeetEveryInputAndGoOnBeyondTheEnds)
{
    for (int i = 0; i < 5; ++i)
        EXPECT_EQ(line_weights(5, 0.25 * i), VectorXd::Unit(5, i));
    EXPECT_EQ(line_weights(2, 0.25), Eigen::Vector2d(0.75, 0.25));
    EXPECT_EQ(line_weights(3, 0.625), Eigen::Vector3d(0.0, 0.75, 0.25));
    EXPECT_EQ(line_weights(3, -0.25), Eigen::Vector3d(1.5, -0.5, 0.0));
    EXPECT_EQ(line_weights(3, 1.25), Eigen::Vector3d(0.0, -0.5, 1.5));
}

TEST(BilinearWeights, MeetTheCornersInTheirOrder)
{
    EXPECT_EQ(bilinear_weights(0, 0), Eigen::Vector4d(1, 0, 0, 0));
    EXPECT_EQ(bilinear_weights(1, 0), Eigen::Vector4d(0, 1, 0, 0));
    EXPECT_EQ(bilinear_weights(0, 1), Eigen::Vector4d(0, 0, 1, 0));
    EXPECT_EQ(bilinear_weights(1, 1), Eigen::Vector4d(0, 0, 0, 1));
    EXPECT_EQ(bilinear_weights(0.5, 0.25), Eigen::Vector4d(0.375, 0.375, 0.125, 0.125));
}

TEST(CatmullRomWeights, MeetEveryInput)
{
    VectorXd uneven(5);
    uneven << -1.0, 0.5, 1.0, 4.0, 4.25;
    for (const VectorXd& knots : {uniform_knots(5), uneven})
        for (int i = 0; i < 5; ++i)
            EXPECT_EQ(catmull_rom_weights(knots, knots[i]), VectorXd::Unit(5, i));
}

TEST(CatmullRomWeights, AreThoseOfCatmullAndRomForEqualSpacing)
{
    // At the middle of an inner interval: -1/16, 9/16, 9/16, -1/16.
    const VectorXd weights = catmull_rom_weights(uniform_knots(6), 2.5);
    VectorXd expected = VectorXd::Zero(6);
    expected.segment(1, 4) << -1.0, 9.0, 9.0, -1.0;
    EXPECT_LT((weights - expected / 16.0).norm(), 1e-15);
}

TEST(CatmullRomWeights, ReproduceParabolasInsideAndLinesEverywhere)
{
    VectorXd knots(6);
    knots << 0.0, 1.0, 3.0, 3.5, 6.0, 7.0;
    for (double t = 0.0; t <= 7.0; t += 0.01)
        EXPECT_NEAR(catmull_rom_weights(knots, t).dot(knots), t, 1e-13);
    for (double t = 1.0; t <= 6.0; t += 0.01)
        EXPECT_NEAR(catmull_rom_weights(knots, t).dot(knots.cwiseAbs2()), t * t, 1e-12);
}

TEST(CatmullRomWeights, HaveNoKink)
{
    VectorXd knots(5);
    knots << 0.0, 1.0, 1.5, 4.0, 5.0;
    const auto path = [&](double t) { return catmull_rom_weights(knots, t); };
    for (int i = 1; i < 4; ++i)
        EXPECT_LT((slope(path, knots[i] - 1e-5) - slope(path, knots[i] + 1e-5)).norm(), 1e-3);
}

TEST(BSplineWeights, BeginAndEndAtTheOuterInputs)
{
    for (int n = 2; n <= 7; ++n) {
        EXPECT_EQ(b_spline_weights(n, 0.0), VectorXd::Unit(n, 0));
        EXPECT_EQ(b_spline_weights(n, 1.0), VectorXd::Unit(n, n - 1));
    }
}

TEST(BSplineWeights, OfFourInputsAreBernsteinPolynomials)
{
    const double t = 0.3;
    const double s = 1.0 - t;
    const Eigen::Vector4d expected(s * s * s, 3 * s * s * t, 3 * s * t * t, t * t * t);
    EXPECT_LT((b_spline_weights(4, t) - expected).norm(), 1e-15);
    EXPECT_LT((b_spline_weights(3, t) - Eigen::Vector3d(s * s, 2 * s * t, t * t)).norm(), 1e-15);
    EXPECT_LT((b_spline_weights(2, t) - Eigen::Vector2d(s, t)).norm(), 1e-15);
}

TEST(BSplineWeights, FarFromTheEndsAreUniform)
{
    // 11 inputs: 8 intervals; at the knot 4 the weights are 1/6, 2/3, 1/6.
    const VectorXd weights = b_spline_weights(11, 0.5);
    EXPECT_LT((weights.segment(4, 3) - Eigen::Vector3d(1, 4, 1) / 6.0).norm(), 1e-15);
    EXPECT_NEAR(weights.segment(4, 3).sum(), 1.0, 1e-15);
}

TEST(BSplineWeights, BendWithoutJumps)
{
    const auto path = [](double t) { return b_spline_weights(8, t); };
    const auto bend = [&](double t) -> VectorXd {
        const double h = 1e-4;
        return (path(t + h) - 2.0 * path(t) + path(t - h)) / (h * h);
    };
    for (int i = 1; i < 5; ++i) {
        const double knot = i / 5.0;
        const double scale = bend(knot).norm();
        EXPECT_LT((bend(knot - 2e-4) - bend(knot + 2e-4)).norm(), 0.02 * scale) << i;
    }
}

TEST(PointOnTrack, MovesAtConstantSpeed)
{
    Eigen::MatrixX2d track(4, 2);
    track << 0, 0, 3, 0, 3, 0, 3, 1; // a point twice is not a stop
    EXPECT_EQ(point_on_track(track, 0.0), Eigen::Vector2d(0, 0));
    EXPECT_EQ(point_on_track(track, 1.0), Eigen::Vector2d(3, 1));
    EXPECT_LT((point_on_track(track, 0.5) - Eigen::Vector2d(2, 0)).norm(), 1e-15);
    EXPECT_LT((point_on_track(track, 0.875) - Eigen::Vector2d(3, 0.5)).norm(), 1e-15);
    EXPECT_EQ(point_on_track(track.topRows(1), 0.4), Eigen::Vector2d(0, 0));
}

TEST(Paths, RefuseWhatIsOutOfRange)
{
    EXPECT_THROW((void)line_weights(1, 0.5), InvalidInput);
    EXPECT_THROW((void)line_weights(2, nan), InvalidInput);
    EXPECT_THROW((void)bilinear_weights(nan, 0.0), InvalidInput);
    EXPECT_THROW((void)catmull_rom_weights(uniform_knots(1), 0.0), InvalidInput);
    EXPECT_THROW((void)catmull_rom_weights(uniform_knots(3), 2.5), InvalidInput);
    EXPECT_THROW((void)catmull_rom_weights(uniform_knots(3), nan), InvalidInput);
    EXPECT_THROW((void)catmull_rom_weights(Eigen::Vector3d(0, 1, 1), 0.5), InvalidInput);
    EXPECT_THROW((void)b_spline_weights(1, 0.5), InvalidInput);
    EXPECT_THROW((void)b_spline_weights(4, 1.5), InvalidInput);
    EXPECT_THROW((void)point_on_track(Eigen::MatrixX2d(0, 2), 0.5), InvalidInput);
    EXPECT_THROW((void)point_on_track(Eigen::MatrixX2d::Zero(2, 2), -0.5), InvalidInput);
}

} // namespace
} // namespace shape
