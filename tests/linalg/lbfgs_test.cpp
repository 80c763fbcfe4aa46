// SPDX-License-Identifier: MIT

#include "libshape/linalg/lbfgs.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "libshape/base/error.h"

namespace shape {
using namespace internal;
namespace {

/// sum of i (x_i - i)^2 over i = 1 ... n: 0 at x_i = i.
double bowl(const Eigen::VectorXd& x, Eigen::VectorXd& gradient)
{
    const Eigen::ArrayXd i =
        Eigen::ArrayXd::LinSpaced(x.size(), 1.0, static_cast<double>(x.size()));
    gradient = 2.0 * i * (x.array() - i);
    return (i * (x.array() - i).square()).sum();
}

/// Rosenbrock's valley: 0 at (1, 1), curved, no bowl.
double valley(const Eigen::VectorXd& x, Eigen::VectorXd& gradient)
{
    const double across = x[1] - x[0] * x[0];
    gradient.resize(2);
    gradient << -400.0 * x[0] * across - 2.0 * (1.0 - x[0]), 200.0 * across;
    return 100.0 * across * across + (1.0 - x[0]) * (1.0 - x[0]);
}

TEST(Lbfgs, FindsTheBottomOfABowlOfAnySize)
{
    for (const int n : {1, 2, 7, 16, 33, 100}) { // libLBFGS may round n up to a multiple of 16
        const Minimum minimum =
            minimize_lbfgs(bowl, Eigen::VectorXd::Zero(n),
                           {.gradient_tolerance = 1e-9, .decrease_tolerance = 0.0});
        EXPECT_TRUE(minimum.converged);
        ASSERT_EQ(minimum.point.size(), n);
        for (int i = 0; i < n; ++i)
            EXPECT_NEAR(minimum.point[i], i + 1.0, 1e-9);
    }
}

TEST(Lbfgs, FollowsACurvedValley)
{
    const Minimum minimum =
        minimize_lbfgs(valley, Eigen::Vector2d(-1.2, 1.0),
                       {.gradient_tolerance = 1e-10, .decrease_tolerance = 0.0});
    EXPECT_TRUE(minimum.converged);
    EXPECT_LT((minimum.point - Eigen::Vector2d(1.0, 1.0)).norm(), 1e-9);
    EXPECT_LE(minimum.evaluations, 100);
    EXPECT_GE(minimum.evaluations, minimum.iterations);
}

TEST(Lbfgs, StopsAtEitherTolerance)
{
    const Eigen::VectorXd start = Eigen::VectorXd::Zero(50);
    Eigen::VectorXd gradient(50);
    const Minimum flat =
        minimize_lbfgs(bowl, start, {.gradient_tolerance = 1.0, .decrease_tolerance = 0.0});
    EXPECT_TRUE(flat.converged);
    EXPECT_EQ(bowl(flat.point, gradient), flat.value);
    EXPECT_LE(gradient.lpNorm<Eigen::Infinity>(), 1.0);
    const Minimum slow =
        minimize_lbfgs(bowl, start, {.gradient_tolerance = 0.0, .decrease_tolerance = 1e-3});
    EXPECT_TRUE(slow.converged);
    EXPECT_GT(slow.value, 0.0);
    const Minimum at_once = minimize_lbfgs(bowl, slow.point, {.gradient_tolerance = 1e9});
    EXPECT_TRUE(at_once.converged);
    EXPECT_EQ(at_once.iterations, 0);
    EXPECT_EQ(at_once.point, slow.point);
}

TEST(Lbfgs, SaysWhenItRanOutOfIterations)
{
    for (const int limit : {0, 1, 3}) {
        Eigen::VectorXd gradient(50);
        const Minimum minimum =
            minimize_lbfgs(bowl, Eigen::VectorXd::Zero(50), {.max_iterations = limit});
        EXPECT_FALSE(minimum.converged);
        EXPECT_EQ(minimum.iterations, limit);
        EXPECT_EQ(bowl(minimum.point, gradient), minimum.value);
    }
}

TEST(Lbfgs, PassesOnWhatItsCallbacksThrow)
{
    int calls = 0;
    const auto stop = [&](int iterations) {
        EXPECT_EQ(iterations, ++calls);
        if (calls == 3)
            throw Interrupted("enough");
    };
    EXPECT_THROW((void)minimize_lbfgs(bowl, Eigen::VectorXd::Zero(50), {}, stop), Interrupted);
    EXPECT_EQ(calls, 3);
    int evaluations = 0;
    const auto break_down = [&](const Eigen::VectorXd& x, Eigen::VectorXd& gradient) {
        if (++evaluations == 4)
            throw NumericalError("broken");
        return bowl(x, gradient);
    };
    EXPECT_THROW((void)minimize_lbfgs(break_down, Eigen::VectorXd::Zero(50)), NumericalError);
}

TEST(Lbfgs, RefusesBrokenArguments)
{
    const auto with = [](const LbfgsOptions& options) {
        return minimize_lbfgs(bowl, Eigen::VectorXd::Zero(3), options);
    };
    EXPECT_THROW((void)with({.memory = 0}), InvalidInput);
    EXPECT_THROW((void)with({.gradient_tolerance = -1.0}), InvalidInput);
    EXPECT_THROW((void)with({.decrease_tolerance = -1.0}), InvalidInput);
    EXPECT_THROW((void)with({.max_iterations = -1}), InvalidInput);
    const double nan = std::numeric_limits<double>::quiet_NaN();
    EXPECT_THROW((void)minimize_lbfgs(bowl, Eigen::VectorXd::Constant(3, nan)), NumericalError);
}

} // namespace
} // namespace shape
