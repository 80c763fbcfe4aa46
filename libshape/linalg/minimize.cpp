// SPDX-License-Identifier: MIT

#include "libshape/linalg/minimize.h"

#include <cmath>
#include <deque>
#include <vector>

#include "libshape/base/error.h"
#include "libshape/base/format.h"

namespace shape {
namespace {

using Eigen::VectorXd;

/// One step s and the change y of the gradient along it.
struct Pair
{
    VectorXd s;
    VectorXd y;
    double sy;
};

/// - H g by the two-loop recursion.
VectorXd search_direction(const std::deque<Pair>& pairs, const VectorXd& gradient,
                          const Preconditioner& precondition)
{
    VectorXd q = -gradient;
    std::vector<double> alpha(pairs.size());
    for (std::size_t i = pairs.size(); i-- > 0;) {
        alpha[i] = pairs[i].s.dot(q) / pairs[i].sy;
        q.noalias() -= alpha[i] * pairs[i].y;
    }
    VectorXd direction = precondition(q);
    for (std::size_t i = 0; i < pairs.size(); ++i) {
        const double beta = pairs[i].y.dot(direction) / pairs[i].sy;
        direction.noalias() += (alpha[i] - beta) * pairs[i].s;
    }
    return direction;
}

} // namespace

Minimum minimize(const Objective& objective, const Preconditioner& precondition,
                 Eigen::VectorXd start, const MinimizeOptions& options)
{
    if (options.memory < 1 || options.max_iterations < 0 || options.window < 1)
        throw InvalidInput(join("minimize: memory ", options.memory, ", max_iterations ",
                                options.max_iterations, ", window ", options.window,
                                "; must be >= 1, >= 0, >= 1"));
    Minimum result;
    result.point = std::move(start);
    VectorXd gradient(result.point.size());
    result.value = objective(result.point, gradient);
    result.evaluations = 1;
    if (!std::isfinite(result.value))
        throw NumericalError("minimize: the function is not finite at the start");

    std::deque<Pair> pairs;
    std::deque<double> window{result.value};
    VectorXd next_gradient(result.point.size());
    result.converged = result.value <= options.value_tolerance;
    while (!result.converged && result.iterations < options.max_iterations) {
        const VectorXd direction = search_direction(pairs, gradient, precondition);
        const double slope = gradient.dot(direction);
        if (!(slope < 0.0)) // also where the gradient vanishes
            break;
        double step = 1.0;
        VectorXd next = result.point + direction;
        double value = objective(next, next_gradient);
        ++result.evaluations;
        constexpr double smallest_step = 1e-9;
        while (!(value <= result.value + 1e-4 * step * slope) && step > smallest_step) {
            step *= 0.5;
            next = result.point + step * direction;
            value = objective(next, next_gradient);
            ++result.evaluations;
        }
        if (step <= smallest_step)
            break;
        Pair pair{next - result.point, next_gradient - gradient, 0.0};
        pair.sy = pair.s.dot(pair.y);
        if (pair.sy > 1e-12 * pair.s.norm() * pair.y.norm()) { // keeps H positive definite
            pairs.push_back(std::move(pair));
            if (pairs.size() > static_cast<std::size_t>(options.memory))
                pairs.pop_front();
        }
        result.point = std::move(next);
        result.value = value;
        gradient.swap(next_gradient);
        ++result.iterations;
        window.push_back(value);
        if (window.size() > static_cast<std::size_t>(options.window)) {
            result.converged = window.front() - value <= options.decrease_tolerance * value;
            window.pop_front();
        }
        result.converged = result.converged || value <= options.value_tolerance;
    }
    return result;
}

} // namespace shape
