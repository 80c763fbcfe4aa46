// SPDX-License-Identifier: MIT

#pragma once

namespace shape::internal {

/// P(|T| >= |t|) for Student's t distribution: I_x(n/2, 1/2), x = n / (n + t^2), where I is the
/// regularised incomplete beta function, here by its continued fraction (DLMF 8.17.22).
/// @param t  Any number; infinite gives 0.
/// @param degrees_of_freedom  n > 0; need not be an integer.
/// @throws InvalidInput if t is NaN or n is not > 0 and finite.
/// Accuracy: 1e-11 relative for n <= 1e4, however small the result.
[[nodiscard]] double two_sided_t_probability(double t, double degrees_of_freedom);

} // namespace shape::internal
