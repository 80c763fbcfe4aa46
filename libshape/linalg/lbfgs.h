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
    int evaluations = 0; ///< Value and gradient were evaluated this often.
    bool converged = false;
};

struct LbfgsOptions
{
    /// The Hessian is estimated from this many of the last steps; >= 1.
    int memory = 5;
    /// It has converged where max_i |g_i| <= gradient_tolerance; >= 0.
    double gradient_tolerance = 1e-5;
    /// It has converged as well once a step lowers f by <= decrease_tolerance * max(1, |f|); >= 0.
    double decrease_tolerance = 2.2e-9;
    /// It ends after this many steps; >= 0.
    int max_iterations = 15000;
};

/// @throws InvalidInput naming the first field that breaks its rule.
void check(const LbfgsOptions& options);

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
