// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>

// Weights of the inputs along paths through the space; polygons are in mean_value_coordinates.h. All
// weights sum to 1 up to rounding, and are exactly 0 and 1 where a path meets an input.

namespace shape {

/// Weights along the straight lines that join the inputs in order, in equal shares of t: input i is
/// reached at t = i / (inputs - 1). Below 0 and above 1 the first and the last line go on.
/// @param inputs  >= 2.
/// @throws InvalidInput if there are fewer inputs or t is not finite.
[[nodiscard]] Eigen::VectorXd line_weights(int inputs, double t);

/// Weights of the four corners of a bilinear patch: those at (0, 0), (1, 0), (0, 1), (1, 1).
/// @throws InvalidInput if u or v is not finite.
[[nodiscard]] Eigen::Vector4d bilinear_weights(double u, double v);

/// Weights along the curve that meets value i at knots[i], has the slope of the parabola through
/// three neighbours at inner knots and that of the chord at the ends: continuously differentiable.
/// Equally spaced knots give the Catmull-Rom spline (1974). Two knots give a line. Some weights are
/// negative between knots.
/// @param knots  At least two, increasing.
/// @param t  In [first knot, last knot].
/// @throws InvalidInput if a rule is broken.
[[nodiscard]] Eigen::VectorXd catmull_rom_weights(const Eigen::VectorXd& knots, double t);

/// Weights along the uniform cubic B-spline with the inputs as control points, clamped: it begins at
/// the first and ends at the last, and passes near those between. Twice continuously differentiable,
/// weights in [0, 1]. Of lower degree for fewer than four inputs.
/// @param inputs  >= 2.
/// @param t  In [0, 1].
/// @throws InvalidInput if a rule is broken.
[[nodiscard]] Eigen::VectorXd b_spline_weights(int inputs, double t);

/// The point at a share of the length of the polyline through the rows.
/// @param track  n >= 1 by 2, finite.
/// @param share  In [0, 1].
/// @throws InvalidInput if a rule is broken.
[[nodiscard]] Eigen::Vector2d point_on_track(const Eigen::MatrixX2d& track, double share);

} // namespace shape
