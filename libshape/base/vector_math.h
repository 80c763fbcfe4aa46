// SPDX-License-Identifier: MIT

#pragma once

#include <cstddef>

namespace shape::internal {

// The standard library's functions of angles for many values at once, in loops without a branch or
// a call: several times faster. Same bits for a value wherever it stands.

/// sines[i] = sin(angles[i]), cosines[i] = cos(angles[i]), both within 1e-15 + 1e-16 |angles[i]| of it.
/// @param angles  `count` values [rad].
void sines_cosines(const double* angles, std::size_t count, double* sines, double* cosines);

/// angles[i] = atan2(y[i], x[i]) in [-pi, pi], within 1e-15 relative; 0 where both are 0.
void vector_angles(const double* y, const double* x, std::size_t count, double* angles);

/// The same in single precision, within 3e-7 relative.
void vector_angles(const float* y, const float* x, std::size_t count, float* angles);

} // namespace shape::internal
