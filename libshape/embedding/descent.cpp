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

/// Calls work(begin, end) for consecutive ranges of columns.
template <class Work>
void for_columns(Index columns, const Work& work)
{
    constexpr std::size_t grain = 2048;
    parallel_for(static_cast<std::size_t>(columns), grain, work);
}

/// to += factor * by, for a range of vectors.
void add(float factor, const LaneVectors& by, LaneVectors& to, std::size_t begin, std::size_t end)
{
    for (std::size_t i = begin; i < end; ++i)
        lanes(to)[i] += factor * lanes(by)[i];
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
    /// @param b  Ends as the residual.
    Solution solve(GaussNewtonOperator& matrix, const SinglePrecisionSolve& preconditioner,
                   LaneVectors& b, int max_steps, LaneVectors& s)
    {
        Solution solution;
        s.setZero(4, b.cols());
        direction_.setZero(4, b.cols());
        double square = 1.0; // of the residual in the norm of the preconditioner
        double first_square = 0.0;
        while (solution.steps < max_steps) {
            const double last_square =
                std::exchange(square, preconditioner.solve(b, preconditioned_, workspace_));
            if (++solution.steps == 1)
                first_square = square;
            constexpr double rounding = 1e-10; // the residual is 1e-5 of what it was
            if (!(square > rounding * first_square))
                break;
            const auto ratio = static_cast<float>(square / last_square);
            for_columns(b.cols(), [&](std::size_t begin, std::size_t end) {
                for (std::size_t i = begin; i < end; ++i)
                    lanes(direction_)[i] = lanes(preconditioned_)[i] + ratio * lanes(direction_)[i];
            });
            const double curvature = matrix.apply(direction_, image_);
            if (!(curvature > 0.0))
                break;
            const double step = square / curvature;
            for_columns(b.cols(), [&](std::size_t begin, std::size_t end) {
                add(static_cast<float>(step), direction_, s, begin, end);
                add(static_cast<float>(-step), image_, b, begin, end);
            });
            solution.decrease += 0.5 * step * square;
        }
        return solution;
    }

private:
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
    LaneVectors pull; // then the residual
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
            for_columns(step.cols(), [&](std::size_t begin, std::size_t end) {
                for (auto i = static_cast<Index>(begin); i < static_cast<Index>(end); ++i)
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
