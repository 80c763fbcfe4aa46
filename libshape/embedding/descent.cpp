// SPDX-License-Identifier: MIT

#include "libshape/embedding/descent.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/threads.h"
#include "libshape/embedding/gauss_newton_operator.h"

namespace shape {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr std::size_t grain = 16384;

/// Calls work(first, count) for consecutive ranges of the columns.
template <class Work>
void for_columns(Index columns, const Work& work)
{
    parallel_for(static_cast<std::size_t>(columns), grain, [&](std::size_t begin, std::size_t end) {
        work(static_cast<Index>(begin), static_cast<Index>(end - begin));
    });
}

/// a + factor b in the place of `to`, which may be a or b.
void combine(const LaneVectors& a, double factor, const LaneVectors& b, LaneVectors& to)
{
    const auto scale = static_cast<float>(factor);
    for_columns(a.cols(), [&](Index first, Index count) {
        to.middleCols(first, count) =
            a.middleCols(first, count) + scale * b.middleCols(first, count);
    });
}

/// Conjugate gradients for H s = b, their vectors kept from one call to the next.
class ConjugateGradients
{
public:
    struct Solution
    {
        double decrease = 0.0; ///< b . s - s . H s / 2 >= 0.
        int steps = 0;
    };

    /// Starts from s = 0.
    Solution solve(GaussNewtonOperator& matrix, const SinglePrecisionSolve& preconditioner,
                   const LaneVectors& b, int max_steps, LaneVectors& s)
    {
        Solution solution;
        s.setZero(4, b.cols());
        residual_ = b;
        double square = 0.0; // of the residual in the norm of the preconditioner
        double first_square = 0.0;
        while (solution.steps < max_steps) {
            const double last_square = std::exchange(
                square, preconditioner.solve(residual_, preconditioned_, workspace_));
            ++solution.steps;
            if (solution.steps == 1) {
                first_square = square;
                direction_ = preconditioned_;
            } else {
                combine(preconditioned_, square / last_square, direction_, direction_);
            }
            constexpr double rounding = 1e-10; // the residual is 1e-5 of what it was
            if (!(square > rounding * first_square))
                break;
            const double curvature = matrix.apply(direction_, image_);
            if (!(curvature > 0.0))
                break;
            const double step = square / curvature;
            combine(s, step, direction_, s);
            combine(residual_, -step, image_, residual_);
            solution.decrease += 0.5 * step * square;
        }
        return solution;
    }

private:
    LaneVectors residual_;
    LaneVectors preconditioned_;
    LaneVectors direction_;
    LaneVectors image_;
    LaneVectors workspace_; // of the preconditioner
};

} // namespace

Descent descend(LengthDihedralEnergy& energy, const SinglePrecisionSolve& preconditioner,
                VectorXd start, const DescentOptions& options)
{
    if (options.max_linear_steps < 0 || options.first_linear_steps < 2)
        throw InvalidInput(join("descent: max_linear_steps is ", options.max_linear_steps,
                                ", first_linear_steps ", options.first_linear_steps,
                                "; must be >= 0 and >= 2"));
    Descent result;
    result.points = std::move(start);
    VectorXd gradient;
    result.energy = energy.evaluate(result.points, gradient);
    if (!std::isfinite(result.energy))
        throw NumericalError("descent: the energy is not finite at the start");
    result.converged = result.energy <= options.value_tolerance;

    GaussNewtonOperator matrix(energy);
    ConjugateGradients conjugate_gradients;
    LaneVectors pull;
    LaneVectors step;
    VectorXd next(result.points.size());
    VectorXd next_gradient;
    int steps = options.first_linear_steps;
    while (!result.converged && result.linear_steps < options.max_linear_steps) {
        matrix.linearise(result.points);
        to_lanes(gradient.data(), gradient.size() / 3, -0.5 * matrix.unit(), pull);
        const auto [decrease, taken] = conjugate_gradients.solve(
            matrix, preconditioner, pull,
            std::min(steps, options.max_linear_steps - result.linear_steps), step);
        result.linear_steps += taken;
        double scale = 1.0;
        double value = result.energy;
        for (int halving = 0; halving < 20; ++halving, scale *= 0.5) {
            for_columns(step.cols(), [&](Index first, Index count) {
                for (Index i = first; i < first + count; ++i)
                    next.segment<3>(3 * i) =
                        result.points.segment<3>(3 * i) +
                        scale * matrix.unit() * step.col(i).head<3>().cast<double>();
            });
            value = energy.evaluate(next, next_gradient);
            if (value < result.energy)
                break;
        }
        if (!(value < result.energy)) { // a minimum up to rounding
            result.converged = true;
            break;
        }
        const double lowered = result.energy - value;
        const double agreement = lowered / (2.0 * decrease); // E is the sum of squares, not half
        // A step that did not do what it promised says nothing about how much is left.
        result.converged =
            (agreement > 0.25 && lowered <= taken * options.decrease_tolerance * value) ||
            value <= options.value_tolerance;
        result.points.swap(next);
        gradient.swap(next_gradient);
        result.energy = value;
        if (agreement > 0.7)
            steps = steps + steps / 2;
        else if (agreement < 0.6)
            steps = std::max(steps / 2, options.first_linear_steps / 2);
    }
    return result;
}

} // namespace shape
