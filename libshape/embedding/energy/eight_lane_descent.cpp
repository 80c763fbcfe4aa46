// SPDX-License-Identifier: MIT

#include "libshape/embedding/energy/eight_lane_descent.h"

#include "libshape/base/require.h"
#include "libshape/base/vectorised.h"

namespace shape::internal {
namespace {

// Conjugate gradients on eight systems J^T J s = -J^T r of the same pattern in SIMD lanes: every scalar of
// the method, square, curvature, ratio, is eight numbers, one a position (the layout: eight_lane_energy.cpp).
// Eight runs one after the other would read indices and the factor of the preconditioner eight
// times. A lane whose residual has come down to rounding takes steps of length 0 while others go on.

SHAPE_VECTORISED void inner_product(std::size_t count, const EightLanePoint* a,
                                    const EightLanePoint* b, EightLanes* __restrict product)
{
    EightLanes sum{};
    for (std::size_t i = 0; i < count; ++i)
        sum = sum + dot(a[i], b[i]);
    *product = sum;
}

/// to = a + factor b; to may be a or b.
SHAPE_VECTORISED void combine(std::size_t count, const EightLanePoint* a, const EightLanes* factor,
                              const EightLanePoint* b, EightLanePoint* to)
{
    const EightLanes scale = *factor;
    for (std::size_t i = 0; i < count; ++i)
        to[i] = a[i] + scale * b[i];
}

/// Conjugate gradients for J^T J s = -J^T r from s = 0.
class EightLaneConjugateGradients
{
public:
    explicit EightLaneConjugateGradients(const EightLanePoints& points) : direction_(points.size())
    {
    }

    const EightLanePoints& solve(EightLaneEnergy& matrix, const EightLaneSolve& preconditioner,
                                 int steps)
    {
        const EightLanes minus = EightLanes::all(-1.0F);
        matrix.gradient(residual_);
        const std::size_t size = residual_.size();
        solution_.assign(size, {});
        combine(size, solution_.data(), &minus, residual_.data(), residual_.data());
        EightLanes square{};
        EightLanes least{};
        for (int step = 0; step < steps; ++step) {
            preconditioned_ = residual_;
            preconditioner.solve(preconditioned_);
            const EightLanes last = square;
            inner_product(size, residual_.data(), preconditioned_.data(), &square);
            const EightLanes along = step == 0 ? EightLanes{} : ratio(square, last, least);
            if (step == 0)
                least = 1e-10F * square; // the residual is 1e-5 of what it was
            combine(size, preconditioned_.data(), &along, direction_.data(), direction_.data());
            matrix.apply(direction_, image_);
            EightLanes curvature;
            inner_product(size, direction_.data(), image_.data(), &curvature);
            EightLanes length = ratio(square, curvature, EightLanes{});
            for (std::size_t k = 0; k < EightLanes::lanes; ++k)
                if (!(square.of[k] > least.of[k]))
                    length.of[k] = 0.0F;
            combine(size, solution_.data(), &length, direction_.data(), solution_.data());
            length = minus * length;
            combine(size, residual_.data(), &length, image_.data(), residual_.data());
        }
        return solution_;
    }

private:
    /// a / b, 0 where b is not above its bound.
    static EightLanes ratio(const EightLanes& a, const EightLanes& b, const EightLanes& bound)
    {
        EightLanes result{};
        for (std::size_t k = 0; k < EightLanes::lanes; ++k)
            if (b.of[k] > bound.of[k])
                result.of[k] = a.of[k] / b.of[k];
        return result;
    }

    EightLanePoints residual_, preconditioned_, image_, solution_;
    EightLanePoints direction_; // of all vertices of the region
};

} // namespace

void check(const EightLaneDescentOptions& options)
{
    require_at_least(0, options.newton_steps, "EightLaneDescentOptions.newton_steps");
    require_at_least(1, options.linear_steps, "EightLaneDescentOptions.linear_steps");
    require_at_least(0, options.halvings, "EightLaneDescentOptions.halvings");
}

std::array<float, EightLanes::lanes> descend(EightLaneEnergy& energy,
                                             const EightLaneSolve& preconditioner,
                                             EightLanePoints& points,
                                             const EightLaneDescentOptions& options)
{
    check(options);
    EightLaneConjugateGradients conjugate_gradients(points);
    EightLanePoints next = points;
    auto value = energy.linearise(points);
    // 0 once no part of a step made the energy of a position fall: the same step would come again.
    EightLanes first_scale = EightLanes::all(1.0F);
    for (int newton = 0; newton < options.newton_steps; ++newton) {
        const EightLanePoints& step =
            conjugate_gradients.solve(energy, preconditioner, options.linear_steps);
        EightLanes scale = first_scale;
        for (int halving = 0;; ++halving) {
            combine(step.size(), points.data(), &scale, step.data(), next.data());
            const auto trial = energy.linearise(next);
            bool fell = true;
            for (std::size_t k = 0; k < EightLanes::lanes; ++k)
                if (scale.of[k] > 0.0F && !(trial[k] < value[k])) {
                    scale.of[k] = halving < options.halvings ? 0.5F * scale.of[k] : 0.0F;
                    fell = false;
                }
            if (!fell)
                continue;
            bool any = false;
            for (std::size_t k = 0; k < EightLanes::lanes; ++k)
                if (scale.of[k] > 0.0F) {
                    value[k] = trial[k];
                    any = true;
                } else {
                    first_scale.of[k] = 0.0F;
                }
            if (!any)
                return value;
            break;
        }
        points.swap(next);
    }
    return value;
}

} // namespace shape::internal
