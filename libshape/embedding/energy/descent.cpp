// SPDX-License-Identifier: MIT

#include "libshape/embedding/energy/descent.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "libshape/base/error.h"
#include "libshape/base/require.h"
#include "libshape/base/threads.h"
#include "libshape/base/to_size.h"
#include "libshape/embedding/energy/gauss_newton_operator.h"

namespace shape::internal {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

/// Calls work(begin, end) for consecutive ranges of columns.
template <class Work>
void for_columns(Index columns, const Work& work)
{
    constexpr std::size_t grain = 2048;
    parallel_for(to_size(columns), grain, work);
}

/// to += factor * by, for a range of vectors.
void add(float factor, const LaneVectors& by, LaneVectors& to, std::size_t begin, std::size_t end)
{
    for (std::size_t i = begin; i < end; ++i)
        lanes(to)[i] += factor * lanes(by)[i];
}

void zero_at(const std::vector<int>& vertices, LaneVectors& vectors)
{
    for (const int v : vertices)
        vectors.col(v).setZero();
}

/// A Newton step is halved this many times before edges that rise are held instead: an eighth of a step
/// that still rises is not too long, there is a jump of E on the way.
constexpr int halvings = 3;

/// A Newton step is given up after this many trials, halved up to 16 times by then:
/// what it could still win is below the float digits of its linear system.
constexpr int most_trials = 20;

/// The quadratic model of a Newton step is trusted where E falls by more than this share of what it
/// promised: then the next one takes half as many linear steps again ...
constexpr double good_agreement = 0.7;
/// ... and where it falls by less than this share, half as many: more exact solutions of a system that
/// does not describe E are wasted. Between the two the number stays, so that it does not swing.
constexpr double poor_agreement = 0.6;
/// A Newton step that did less than this share of what it promised (held by a face about to turn over)
/// says nothing about how far the minimum is: it does not count as converged.
constexpr double telling_agreement = 0.25;

/// Linear steps stop early once they promise less than this share of what decides on convergence: three
/// such cannot keep a Newton step from counting as converged.
constexpr double idle_share = 0.25;

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
    /// @param held  Vertices that do not move.
    /// @param b  Ends as the residual.
    /// @param least  Ends after three steps in a row that lower b . s - s . H s / 2 by less.
    Solution solve(GaussNewtonOperator& matrix, const SinglePrecisionSolve& preconditioner,
                   const std::vector<int>& held, LaneVectors& b, int max_steps, double least,
                   LaneVectors& s)
    {
        Solution solution;
        zero_at(held, b);
        s.setZero(4, b.cols());
        direction_.setZero(4, b.cols());
        double square = 1.0; // of the residual in the norm of the preconditioner
        double first_square = 0.0;
        int small_steps = 0;
        while (solution.steps < max_steps && small_steps < 3) {
            const double last_square =
                std::exchange(square, preconditioner.precondition(b, preconditioned_, workspace_));
            zero_at(held, preconditioned_);
            if (++solution.steps == 1)
                first_square = square;
            // The residual is 1e-5 of what it was: below that there are no digits in float, as rounding of
            // 6e-8 grows by the condition of the preconditioned system.
            constexpr double rounding = 1e-10;
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
            zero_at(held, image_);
            const double step = square / curvature;
            for_columns(b.cols(), [&](std::size_t begin, std::size_t end) {
                add(static_cast<float>(step), direction_, s, begin, end);
                add(static_cast<float>(-step), image_, b, begin, end);
            });
            solution.decrease += 0.5 * step * square;
            small_steps = 0.5 * step * square < least ? small_steps + 1 : 0;
        }
        return solution;
    }

private:
    LaneVectors preconditioned_;
    LaneVectors direction_;
    LaneVectors image_;
    LaneVectors workspace_; // of the preconditioner
};

/// Stops what moves at edges whose energy rose by a large part of what a step missed: faces that turn
/// over, where E jumps.
/// @param missed  By how much E is above what was promised.
/// @param held  The vertices stopped are added.
/// @return Whether any moved.
bool hold_risen(const Topology& topology, const VectorXd& before, const VectorXd& now,
                double missed, LaneVectors& step, std::vector<int>& held)
{
    // With 1/8, at most some eight edges can be to blame: if many more rise a little each, the step is too
    // long everywhere, and halving it is right.
    constexpr double large = 0.125;
    const std::size_t count = held.size();
    for (int e = 0; e < topology.edge_count(); ++e) {
        if (!(now[e] - before[e] > large * missed))
            continue;
        for (int side = 0; side < 2; ++side)
            if (const int h = topology.edge_halfedges()(e, side); h >= 0)
                for (const int v : topology.faces().row(h / 3))
                    if (!step.col(v).isZero(0.0F)) {
                        step.col(v).setZero();
                        held.push_back(v);
                    }
    }
    return held.size() > count;
}

} // namespace

struct Descender::State
{
    LengthDihedralEnergy& energy;
    const SinglePrecisionSolve& preconditioner;
    GaussNewtonOperator matrix;
    ConjugateGradients conjugate_gradients;
    LaneVectors pull; // then the residual
    LaneVectors step;
    VectorXd gradient, next;
    VectorXd edge_energies;

    State(LengthDihedralEnergy& of, const SinglePrecisionSolve& by)
        : energy(of), preconditioner(by), matrix(of)
    {
    }

    /// A Newton step from points, where the energy was evaluated last.
    ConjugateGradients::Solution solve(const VectorXd& points, const std::vector<int>& held,
                                       int max_steps, double least)
    {
        matrix.linearise(points);
        energy.find_gradient(points, gradient);
        to_lanes(gradient.data(), gradient.size() / 3, -0.5 * matrix.unit(), pull);
        return conjugate_gradients.solve(matrix, preconditioner, held, pull, max_steps, least,
                                         step);
    }

    /// E at points + scale * step, which become next.
    double evaluate(const VectorXd& points, double scale)
    {
        next.resize(points.size());
        for_columns(step.cols(), [&](std::size_t begin, std::size_t end) {
            for (auto i = static_cast<Index>(begin); i < static_cast<Index>(end); ++i)
                next.segment<3>(3 * i) =
                    points.segment<3>(3 * i) +
                    scale * matrix.unit() * step.col(i).head<3>().cast<double>();
        });
        return energy.evaluate(next);
    }
};

Descender::Descender(LengthDihedralEnergy& energy, const SinglePrecisionSolve& preconditioner)
    : state_(std::make_unique<State>(energy, preconditioner))
{
}

Descender::~Descender() = default;

void check(const DescentOptions& options)
{
    require_at_least(0, options.max_linear_steps, "DescentOptions.max_linear_steps");
    require_at_least(2, options.first_linear_steps, "DescentOptions.first_linear_steps");
    require_not_negative(options.decrease_tolerance, "DescentOptions.decrease_tolerance");
    require_not_negative(options.value_tolerance, "DescentOptions.value_tolerance");
}

Descent Descender::descend(VectorXd start, const DescentOptions& options)
{
    check(options);
    State& s = *state_;
    Descent result;
    result.points = std::move(start);
    result.energy = s.energy.evaluate(result.points);
    if (!std::isfinite(result.energy))
        throw NumericalError("descent: the energy is not finite at the start");
    result.converged = result.energy <= options.value_tolerance;
    s.edge_energies = s.energy.edge_energies();

    int steps = options.first_linear_steps;
    std::vector<int> held; // vertices that a Newton step must not move
    while (!result.converged && result.linear_steps < options.max_linear_steps) {
        const std::size_t held_before = held.size();
        const auto [decrease, taken] = s.solve(
            result.points, held, std::min(steps, options.max_linear_steps - result.linear_steps),
            idle_share * options.decrease_tolerance * result.energy);
        result.linear_steps += taken;
        double scale = 1.0;
        double value = result.energy;
        for (int trial = 0; trial < most_trials; ++trial) {
            value = s.evaluate(result.points, scale);
            if (value < result.energy)
                break;
            if (trial == halvings)
                scale = 1.0;
            else if (trial < halvings ||
                     !hold_risen(s.energy.topology(), s.edge_energies, s.energy.edge_energies(),
                                 value - result.energy + 2.0 * decrease, s.step, held))
                scale *= 0.5;
        }
        if (!(value < result.energy)) {
            if (held.size() == held_before) { // a minimum up to rounding, if not much was promised
                result.is_measured = false;
                result.converged =
                    held.empty() &&
                    2.0 * decrease <= taken * options.decrease_tolerance * result.energy;
                break;
            }
            (void)s.energy.evaluate(result.points); // solve anew without them
            continue;
        }
        const double lowered = result.energy - value;
        const double agreement = lowered / (2.0 * decrease); // E is the sum of squares, not half
        // A step that did not do what it promised says nothing about how much is left.
        result.converged = (agreement > telling_agreement &&
                            lowered <= taken * options.decrease_tolerance * value) ||
                           value <= options.value_tolerance;
        held.clear();
        result.points.swap(s.next);
        s.edge_energies = s.energy.edge_energies();
        result.energy = value;
        if (agreement > good_agreement)
            steps = steps + steps / 2;
        else if (agreement < poor_agreement)
            steps = std::max(steps / 2, options.first_linear_steps / 2);
    }
    return result;
}

} // namespace shape::internal
