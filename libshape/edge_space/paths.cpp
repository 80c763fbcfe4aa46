// SPDX-License-Identifier: MIT

#include "libshape/edge_space/paths.h"

#include <algorithm>
#include <cmath>

#include "libshape/base/error.h"
#include "libshape/base/format.h"

namespace shape {
using namespace internal;
namespace {

using Eigen::Index;
using Eigen::VectorXd;

void check_inputs(int inputs)
{
    if (inputs < 2)
        throw InvalidInput(join("a path needs at least 2 inputs, not ", inputs));
}

void check_parameter(double t, double low, double high)
{
    if (!(t >= low && t <= high))
        throw InvalidInput(
            join("the parameter of the path is ", t, ", must be in [", low, ", ", high, "]"));
}

/// The interval between knots that t lies in: the last one that begins at or before it.
Index interval_of(const VectorXd& knots, double t)
{
    const auto after = std::upper_bound(knots.begin(), knots.end() - 1, t);
    return std::max<Index>(after - knots.begin() - 1, 0);
}

} // namespace

VectorXd line_weights(int inputs, double t)
{
    check_inputs(inputs);
    if (!std::isfinite(t))
        throw InvalidInput(join("the parameter of the path is ", t, ", must be finite"));
    const double along = t * (inputs - 1);
    const double first = std::clamp(std::floor(along), 0.0, inputs - 2.0);
    VectorXd weights = VectorXd::Zero(inputs);
    weights[static_cast<Index>(first)] = 1.0 - (along - first);
    weights[static_cast<Index>(first) + 1] = along - first;
    return weights;
}

Eigen::Vector4d bilinear_weights(double u, double v)
{
    if (!std::isfinite(u) || !std::isfinite(v))
        throw InvalidInput(join("the place in the patch is (", u, ", ", v, "), must be finite"));
    return {(1.0 - u) * (1.0 - v), u * (1.0 - v), (1.0 - u) * v, u * v};
}

VectorXd catmull_rom_weights(const VectorXd& knots, double t)
{
    const Index n = knots.size();
    check_inputs(static_cast<int>(n));
    for (Index i = 1; i < n; ++i)
        if (!(knots[i] > knots[i - 1]) || !std::isfinite(knots[i] - knots[i - 1]))
            throw InvalidInput(join("knot ", i, " is ", knots[i],
                                    ", must be above the one before, ", knots[i - 1]));
    check_parameter(t, knots[0], knots[n - 1]);
    const Index k = interval_of(knots, t);
    const double width = knots[k + 1] - knots[k];
    const double s = (t - knots[k]) / width;

    // Hermite's form: values and slopes at the ends of the interval.
    VectorXd weights = VectorXd::Zero(n);
    weights[k] += (1.0 + 2.0 * s) * (1.0 - s) * (1.0 - s);
    weights[k + 1] += s * s * (3.0 - 2.0 * s);
    const auto add_chord = [&](Index i, double factor) { // (value i+1 - value i) / distance
        weights[i] -= factor / (knots[i + 1] - knots[i]);
        weights[i + 1] += factor / (knots[i + 1] - knots[i]);
    };
    const auto add_slope = [&](Index i, double factor) {
        if (i == 0 || i == n - 1)
            return add_chord(i == 0 ? 0 : n - 2, factor);
        const double before = knots[i] - knots[i - 1];
        const double after = knots[i + 1] - knots[i];
        add_chord(i - 1, factor * after / (before + after));
        add_chord(i, factor * before / (before + after));
    };
    add_slope(k, width * s * (1.0 - s) * (1.0 - s));
    add_slope(k + 1, -width * s * s * (1.0 - s));
    return weights;
}

VectorXd b_spline_weights(int inputs, double t)
{
    check_inputs(inputs);
    check_parameter(t, 0.0, 1.0);
    const int degree = std::min(3, inputs - 1);
    const int intervals = inputs - degree;
    const auto knot = [&](int i) { // clamped: the ends count degree + 1 times
        return static_cast<double>(std::clamp(i - degree, 0, intervals));
    };
    const double x = t * intervals;
    const int k = degree + std::min(static_cast<int>(x), intervals - 1);

    // de Boor's recurrence from degree 0, over the basis functions that are not 0 at x.
    VectorXd basis = VectorXd::Zero(degree + 2);
    basis[degree] = 1.0; // entry j belongs to function k - degree + j
    for (int d = 1; d <= degree; ++d)
        for (int j = degree - d; j <= degree; ++j) {
            const int i = k - degree + j;
            const double rise = knot(i + d) - knot(i);
            const double fall = knot(i + d + 1) - knot(i + 1);
            basis[j] = (rise > 0.0 ? (x - knot(i)) / rise * basis[j] : 0.0) +
                       (fall > 0.0 ? (knot(i + d + 1) - x) / fall * basis[j + 1] : 0.0);
        }
    VectorXd weights = VectorXd::Zero(inputs);
    weights.segment(k - degree, degree + 1) = basis.head(degree + 1);
    return weights;
}

Eigen::Vector2d point_on_track(const Eigen::MatrixX2d& track, double share)
{
    if (track.rows() == 0 || !track.allFinite())
        throw InvalidInput("a track needs at least one point, and finite ones");
    check_parameter(share, 0.0, 1.0);
    const Index pieces = track.rows() - 1;
    const VectorXd lengths = (track.bottomRows(pieces) - track.topRows(pieces)).rowwise().norm();
    double left = share * lengths.sum();
    for (Index i = 0; i < pieces && share < 1.0; ++i) {
        if (left < lengths[i])
            return track.row(i) + left / lengths[i] * (track.row(i + 1) - track.row(i));
        left -= lengths[i];
    }
    return track.row(pieces);
}

} // namespace shape
