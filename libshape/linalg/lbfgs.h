// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <functional>

namespace shape::internal {

/// A function of n variables: returns its value and overwrites the gradient.
using Objective = std::function<double(const Eigen::VectorXd& x, Eigen::VectorXd& gradient)>;

struct Minimum
{
    Eigen::VectorXd point;
    double value = 0.0;
    int iterations = 0;
    int evaluations = 0; ///< Of value and gradient.
    bool converged = false;
};

struct LbfgsOptions
{
    int memory = 5;                     ///< Pairs kept; >= 1.
    double gradient_tolerance = 1e-5;   ///< Converged if max_i |g_i| <= this; >= 0.
    double decrease_tolerance = 2.2e-9; ///< Converged if a step lowers f by <= this * max(1, |f|);
                                        ///< >= 0.
    int max_iterations = 15000;         ///< >= 0.
};

/// Lowers a smooth function by L-BFGS with the line search of More and Thuente (1994), as libLBFGS
/// implements them.
/// @param after_step  Called with the number of iterations; may throw Interrupted.
/// @return The last point, not converged if the iterations ran out or no step lowered f.
/// @throws InvalidInput if an option breaks a rule above.
/// @throws NumericalError if f or its gradient is not finite at the start.
/// Whatever objective or after_step throw is passed on.
[[nodiscard]] Minimum minimize_lbfgs(const Objective& objective, const Eigen::VectorXd& start,
                                     const LbfgsOptions& options = {},
                                     const std::function<void(int iterations)>& after_step = {});

} // namespace shape::internal
