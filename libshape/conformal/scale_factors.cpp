// SPDX-License-Identifier: MIT

#include "libshape/conformal/scale_factors.h"

#include <cmath>
#include <cstdlib>
#include <cstdio>
#include <numbers>

#include "libshape/conformal/angle_defect_energy.h"

namespace shape {
namespace {

/// A triangulation that breaks cannot be solved: nothing is gained by solving it precisely.
constexpr double broken_tolerance = 1e-5;

} // namespace

ScaleFactors solve_scale_factors(const IntrinsicTriangulation& t, const Eigen::VectorXd& initial,
                                 const std::vector<char>& is_free, int removed_vertex,
                                 CotangentSystem& system, const ScaleFactorOptions& options)
{
    const Eigen::VectorXd targets =
        Eigen::VectorXd::Constant(t.vertex_count(), 2.0 * std::numbers::pi);
    const Eigen::VectorXd mask =
        Eigen::Map<const Eigen::Matrix<char, Eigen::Dynamic, 1>>(is_free.data(), t.vertex_count())
            .cast<double>();
    const auto measure = [&](const Eigen::VectorXd& u) {
        AngleDefects state = measure_angle_defects(t, u, targets, removed_vertex);
        state.defects.array() *= mask.array();
        return state;
    };
    const bool verbose = std::getenv("CONF_VERBOSE");

    ScaleFactors result;
    result.u = initial;
    AngleDefects state = measure(initial);
    double residual = state.defects.lpNorm<Eigen::Infinity>();
    while (residual > (state.broken_faces.empty() ? options.tolerance : broken_tolerance) &&
           result.iterations < options.max_iterations) {
        system.factor(state.edge_weights);
        const Eigen::VectorXd step = -system.solve(state.defects);
        const double slope = state.defects.dot(step);
        ++result.iterations;
        // The energy is convex along the step: while its slope is negative it has only fallen.
        double length = 1.0;
        Eigen::VectorXd u;
        AngleDefects next;
        double next_residual = 0.0;
        int evals=0;
        for (;; length *= 0.5) {
            u = result.u + length * step;
            next = measure(u);
            next_residual = next.defects.lpNorm<Eigen::Infinity>();
            ++evals;
            if (next.defects.dot(step) <= 0.1 * std::abs(slope) || length < 1e-10)
                break;
        }
        if (verbose) std::printf("  it %d res %.3e -> %.3e step %.3g len %.3g broken %zu evals %d\n", result.iterations, residual, next_residual, step.lpNorm<Eigen::Infinity>(), length, next.broken_faces.size(), evals);
        const bool at_rounding = residual < 1e-10 && next_residual > 0.5 * residual;
        if (!at_rounding || next_residual < residual) {
            result.u = std::move(u);
            state = std::move(next);
            residual = next_residual;
        }
        if (at_rounding)
            break;
    }
    result.residual = residual;
    result.converged = residual <= 1e-12 && state.broken_faces.empty();
    result.broken_faces = std::move(state.broken_faces);
    result.edge_weights = std::move(state.edge_weights);
    return result;
}

} // namespace shape
