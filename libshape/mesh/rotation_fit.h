// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>

namespace shape::internal {

/// The rotation R of determinant +1 that maximises trace(R^T m), as nearest_rotation() of
/// alignment.h finds it, but several times faster if `guess` is near it.
///
/// Newton's method on the rotation group from `guess`; each step is one symmetric 3 by 3 system and
/// the error falls with its cube. A maximum on the group is global, so wherever the second
/// derivative stops being negative definite, or a step exceeds 70 degrees, the singular value
/// decomposition takes over. Where the maximiser is not unique, one near the guess is taken.
/// @param guess  Orthonormal, determinant +1.
[[nodiscard]] Eigen::Matrix3d nearest_rotation_from(const Eigen::Matrix3d& m,
                                                    const Eigen::Matrix3d& guess);

} // namespace shape::internal
