// SPDX-License-Identifier: MIT

#include "libshape/linalg/lbfgs.h"

#include <lbfgs.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <memory>
#include <new>

#include "libshape/base/error.h"
#include "libshape/base/require.h"

namespace shape::internal {
namespace {

/// What libLBFGS calls back. No exception may cross the C library: the first is kept.
struct Run
{
    const Objective& objective;
    const LbfgsOptions& options;
    const std::function<void(int)>& after_step;
    Minimum result{}; // its point is scratch until the end
    Eigen::VectorXd gradient{};
    std::exception_ptr error{};

    static double evaluate(void* instance, const double* x, double* g, int n, double)
    {
        Run& run = *static_cast<Run*>(instance);
        const Eigen::Index size = run.result.point.size();
        double value = 0.0;
        std::fill(g + size, g + n, 0.0); // libLBFGS may round up the number of variables
        try {
            std::copy_n(x, size, run.result.point.begin());
            value = run.objective(run.result.point, run.gradient);
            ++run.result.evaluations;
            std::copy_n(run.gradient.begin(), size, g);
        } catch (...) {
            run.error = std::current_exception();
        }
        return value;
    }

    /// After every step; anything but 0 ends the run.
    static int step_taken(void* instance, const double*, const double*, double value, double,
                          double, double, int, int k, int)
    {
        Run& run = *static_cast<Run*>(instance);
        const double before = run.result.value;
        run.result.iterations = k;
        run.result.value = value;
        run.result.converged =
            run.gradient.lpNorm<Eigen::Infinity>() <= run.options.gradient_tolerance ||
            before - value <= run.options.decrease_tolerance * std::max(1.0, std::abs(before));
        try {
            if (run.after_step && !run.error)
                run.after_step(k);
        } catch (...) {
            run.error = std::current_exception();
        }
        return run.result.converged || run.error ? 1 : 0;
    }
};

} // namespace

void check(const LbfgsOptions& options)
{
    require_at_least(1, options.memory, "LbfgsOptions.memory");
    require_not_negative(options.gradient_tolerance, "LbfgsOptions.gradient_tolerance");
    require_not_negative(options.decrease_tolerance, "LbfgsOptions.decrease_tolerance");
    require_at_least(0, options.max_iterations, "LbfgsOptions.max_iterations");
}

Minimum minimize_lbfgs(const Objective& objective, const Eigen::VectorXd& start,
                       const LbfgsOptions& options, const std::function<void(int)>& after_step)
{
    check(options);
    Run run{objective, options, after_step};
    run.gradient.setZero(start.size());
    run.result.point = start;
    run.result.value = objective(start, run.gradient);
    run.result.evaluations = 1;
    if (!std::isfinite(run.result.value) || !run.gradient.allFinite())
        throw NumericalError("L-BFGS: the function or its gradient is not finite at the start");
    run.result.converged = run.gradient.lpNorm<Eigen::Infinity>() <= options.gradient_tolerance;
    if (run.result.converged || options.max_iterations == 0)
        return run.result;

    // Built with SSE, libLBFGS wants a multiple of 16 variables, and memory of its own.
    const auto variables = static_cast<int>((start.size() + 15) / 16 * 16);
    const std::unique_ptr<double, void (*)(double*)> x(lbfgs_malloc(variables), lbfgs_free);
    if (!x)
        throw std::bad_alloc();
    std::fill(std::copy(start.begin(), start.end(), x.get()), x.get() + variables, 0.0);
    lbfgs_parameter_t parameters{};
    lbfgs_parameter_init(&parameters);
    parameters.m = options.memory;
    parameters.epsilon = 0.0; // step_taken() decides
    parameters.max_iterations = options.max_iterations;
    lbfgs(variables, x.get(), nullptr, Run::evaluate, Run::step_taken, &run, &parameters);
    if (run.error)
        std::rethrow_exception(run.error);
    // If the line search found nothing lower, libLBFGS has gone back to the last point.
    std::copy_n(x.get(), start.size(), run.result.point.begin());
    return run.result;
}

} // namespace shape::internal
