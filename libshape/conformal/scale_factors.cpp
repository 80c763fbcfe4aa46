// SPDX-License-Identifier: MIT

#include "libshape/conformal/scale_factors.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "libshape/base/require.h"
#include "libshape/base/to_size.h"
#include "libshape/conformal/angle_defect_energy.h"

namespace shape::internal {
namespace {

/// What breaks cannot be solved on these edges: nothing is gained by solving it precisely.
constexpr double broken_tolerance = 1e-5;

/// Limit of a change of u: broken faces have no curvature, where they are many steps are wild.
constexpr double largest_step = 20.0;

/// Cosine of the angle opposite side a, as the algebra has it where lengths break the inequality.
double algebraic_cosine(double log_a, double log_b, double log_c)
{
    return 0.5 * (std::exp(log_b - log_c) + std::exp(log_c - log_b) -
                  std::exp(2.0 * log_a - log_b - log_c));
}

bool is_delaunay(const IntrinsicTriangulation& t, const Eigen::VectorXd& u, int edge)
{
    const auto cosine = [&](int h) {
        return algebraic_cosine(t.scaled_log_length(edge, u),
                                t.scaled_log_length(t.edge(Topology::next(h)), u),
                                t.scaled_log_length(t.edge(Topology::previous(h)), u));
    };
    const int h = t.halfedge(edge);
    // Of four points on a circle the sum is 0 but for rounding: both diagonals count as Delaunay, or
    // flips would go on for ever.
    return !(cosine(h) + cosine(t.opposite(h)) < -1e-12);
}

/// Flips edges that may until all of them are Delaunay. Returns whether there were any.
bool make_delaunay(IntrinsicTriangulation& t, const Eigen::VectorXd& u,
                   const std::vector<char>& may_flip)
{
    std::vector<int> stack;
    for (int e = 0; e < t.edge_count(); ++e)
        if (may_flip[to_size(e)])
            stack.push_back(e);
    bool any = false;
    while (!stack.empty()) {
        const int e = stack.back();
        stack.pop_back();
        if (!t.is_flippable(e) || is_delaunay(t, u, e))
            continue;
        t.flip(e);
        any = true;
        for (const int h : {t.halfedge(e), t.opposite(t.halfedge(e))})
            for (const int side : {Topology::next(h), Topology::previous(h)})
                if (may_flip[to_size(t.edge(side))])
                    stack.push_back(t.edge(side));
    }
    return any;
}

/// A place on the energy: edges, factors and derivatives there.
struct Place
{
    IntrinsicTriangulation triangulation;
    Eigen::VectorXd u;
    AngleDefects angles;
    double residual = 0.0;
    bool flipped = false; ///< The edges are others than at the place before.
};

Place go_to(const IntrinsicTriangulation& t, Eigen::VectorXd u, const ScaleFactorProblem& problem)
{
    Place place{t, std::move(u), {}, 0.0, false};
    place.flipped = make_delaunay(place.triangulation, place.u, problem.may_flip);
    place.angles = measure_angle_defects(place.triangulation, place.u, problem.removed_vertex);
    for (Eigen::Index v = 0; v < place.u.size(); ++v)
        if (!problem.is_free[to_size(v)])
            place.angles.defects[v] = 0.0;
    place.residual = place.angles.defects.lpNorm<Eigen::Infinity>();
    return place;
}

} // namespace

void check(const ScaleFactorOptions& options)
{
    require_positive(options.tolerance, "ScaleFactorOptions.tolerance");
    require_at_least(0, options.max_iterations, "ScaleFactorOptions.max_iterations");
}

ScaleFactors solve_scale_factors(const IntrinsicTriangulation& triangulation,
                                 const Eigen::VectorXd& initial, const ScaleFactorProblem& problem,
                                 const ScaleFactorOptions& options)
{
    check(options);
    Place place = go_to(triangulation, initial, problem);
    CotangentSystem system(place.triangulation, problem.is_free);
    int iterations = 0;
    while (iterations < options.max_iterations &&
           place.residual >
               (place.angles.broken_faces.empty() ? options.tolerance : broken_tolerance)) {
        system.factor(place.angles.edge_weights);
        const Eigen::VectorXd step = -system.solve(place.angles.defects);
        const double slope = place.angles.defects.dot(step);
        ++iterations;
        // The energy is convex: where its slope along the step is still negative it has only
        // fallen. An overshoot to a tenth of the slope is let through, else the last steps would be
        // halved. Within 1e-10 [rad] of flat, rounding decides: a step that does not halve is the last.
        // A length of 1e-10, after 33 halvings, is taken as it is: slopes are continuous, so that one that
        // still rises so near is wrong by rounding.
        double length = std::min(1.0, largest_step / step.lpNorm<Eigen::Infinity>());
        Place next = go_to(place.triangulation, place.u + length * step, problem);
        while (next.angles.defects.dot(step) > 0.1 * std::abs(slope) && length > 1e-10) {
            length *= 0.5;
            next = go_to(place.triangulation, place.u + length * step, problem);
        }
        const bool at_rounding = place.residual < 1e-10 && next.residual > 0.5 * place.residual;
        if (at_rounding && next.residual >= place.residual)
            break;
        place = std::move(next);
        if (place.flipped)
            system = CotangentSystem(place.triangulation, problem.is_free);
        if (at_rounding)
            break;
    }
    return {std::move(place.triangulation),
            std::move(place.u),
            place.residual,
            iterations,
            std::move(place.angles.broken_faces),
            std::move(place.angles.edge_weights),
            std::move(system)};
}

} // namespace shape::internal
