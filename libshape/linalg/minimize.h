// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <functional>

namespace shape {

/// A function of n variables: returns its value and overwrites the gradient.
using Objective = std::function<double(const Eigen::VectorXd& x, Eigen::VectorXd& gradient)>;

/// Applies an approximation of the inverse Hessian: symmetric, positive definite, fixed.
using Preconditioner = std::function<Eigen::VectorXd(const Eigen::VectorXd& gradient)>;

struct MinimizeOptions
{
    int memory = 3;          ///< Pairs kept by L-BFGS; >= 1.
    int max_iterations = 60; ///< >= 0.
    /// Converged once f(x_k) - f(x_(k+window)) <= decrease_tolerance * f(x_(k+window)).
    double decrease_tolerance = 1e-3;
    int window = 5;               ///< >= 1.
    double value_tolerance = 0.0; ///< Converged as well once f <= value_tolerance.
};

struct Minimum
{
    Eigen::VectorXd point;
    double value = 0.0;
    int iterations = 0;  ///< Each one application of the preconditioner.
    int evaluations = 0; ///< Of value and gradient.
    bool converged = false;
};

/// Lowers a function f >= 0 by L-BFGS (Nocedal 1980) whose initial inverse Hessian is a fixed
/// preconditioner; steps are halved until f falls by at
/// least 1e-4 times the step times the slope (Armijo). One evaluation and one application a step is
/// the rule.
/// @throws InvalidInput if an option is out of its range.
/// @throws NumericalError if f is not finite at the start.
[[nodiscard]] Minimum minimize(const Objective& objective, const Preconditioner& precondition,
                               Eigen::VectorXd start, const MinimizeOptions& options = {});

} // namespace shape
