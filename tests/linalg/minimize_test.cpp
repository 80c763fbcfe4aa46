// SPDX-License-Identifier: MIT

#include "libshape/linalg/minimize.h"

#include <gtest/gtest.h>

#include <limits>

#include "libshape/base/error.h"

namespace shape {
namespace {

using Eigen::VectorXd;

const Preconditioner identity = [](const VectorXd& g) { return g; };

TEST(Minimize, EndsAQuadraticWithItsInverseHessianInOneStep)
{
    const VectorXd diagonal = VectorXd::LinSpaced(20, 1.0, 1e6);
    const Objective quadratic = [&](const VectorXd& x, VectorXd& gradient) {
        gradient = diagonal.cwiseProduct(x);
        return 0.5 * x.dot(gradient);
    };
    const Preconditioner inverse = [&](const VectorXd& g) -> VectorXd {
        return g.cwiseQuotient(diagonal);
    };
    const Minimum minimum =
        minimize(quadratic, inverse, VectorXd::Ones(20), {.value_tolerance = 1e-20});
    EXPECT_EQ(minimum.iterations, 1);
    EXPECT_TRUE(minimum.converged);
    EXPECT_LT(minimum.point.norm(), 1e-9);
}

TEST(Minimize, FindsTheMinimumOfRosenbrocksFunction)
{
    const Objective rosenbrock = [](const VectorXd& x, VectorXd& gradient) {
        const double a = 1.0 - x[0];
        const double b = x[1] - x[0] * x[0];
        gradient = Eigen::Vector2d(-2.0 * a - 400.0 * x[0] * b, 200.0 * b);
        return a * a + 100.0 * b * b;
    };
    const Minimum minimum = minimize(rosenbrock, identity, Eigen::Vector2d(-1.2, 1.0),
                                     {.max_iterations = 200, .value_tolerance = 1e-20});
    EXPECT_TRUE(minimum.converged);
    EXPECT_LT((minimum.point - Eigen::Vector2d(1.0, 1.0)).norm(), 1e-8);
}

TEST(Minimize, NeverRisesAndReportsWhereItStopped)
{
    const Objective quartic = [](const VectorXd& x, VectorXd& gradient) {
        gradient = 4.0 * x.array().cube();
        return x.array().pow(4).sum();
    };
    const VectorXd start = VectorXd::LinSpaced(5, -2.0, 3.0);
    double last = std::numeric_limits<double>::infinity();
    for (const int iterations : {0, 1, 2, 5, 10}) {
        const Minimum minimum = minimize(quartic, identity, start,
                                         {.max_iterations = iterations, .decrease_tolerance = 0.0});
        VectorXd gradient;
        EXPECT_EQ(minimum.value, quartic(minimum.point, gradient));
        EXPECT_EQ(minimum.iterations, iterations);
        EXPECT_FALSE(minimum.converged);
        EXPECT_LT(minimum.value, last);
        last = minimum.value;
    }
}

TEST(Minimize, RefusesBadOptionsAndStarts)
{
    const Objective broken = [](const VectorXd& x, VectorXd& gradient) {
        gradient = x;
        return std::numeric_limits<double>::quiet_NaN();
    };
    EXPECT_THROW((void)minimize(broken, identity, VectorXd::Ones(2)), NumericalError);
    EXPECT_THROW((void)minimize(broken, identity, VectorXd::Ones(2), {.memory = 0}), InvalidInput);
    EXPECT_THROW((void)minimize(broken, identity, VectorXd::Ones(2), {.max_iterations = -1}),
                 InvalidInput);
    EXPECT_THROW((void)minimize(broken, identity, VectorXd::Ones(2), {.window = 0}), InvalidInput);
}

} // namespace
} // namespace shape
