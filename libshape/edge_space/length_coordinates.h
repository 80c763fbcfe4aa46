// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>

namespace shape {

/// The function f of an edge length in which meshes are compared and combined.
enum class LengthCoordinates
{
    Plain,   ///< f(l) = l.
    Squared, ///< f(l) = l^2: every combination with weights >= 0 keeps the triangle inequalities.
    Log,     ///< f(l) = log l: relative changes count; every point has lengths > 0.
};

/// f(l), entry by entry.
/// @param lengths  > 0.
[[nodiscard]] Eigen::VectorXd to_coordinates(LengthCoordinates coordinates,
                                             const Eigen::VectorXd& lengths);

/// The inverse of to_coordinates(). Where a squared length is negative, the length is 0.
[[nodiscard]] Eigen::VectorXd to_lengths(LengthCoordinates coordinates,
                                         const Eigen::VectorXd& values);

/// l f'(l): how fast f changes with the relative change of a length.
/// @param lengths  > 0.
[[nodiscard]] Eigen::VectorXd relative_slopes(LengthCoordinates coordinates,
                                              const Eigen::VectorXd& lengths);

} // namespace shape
