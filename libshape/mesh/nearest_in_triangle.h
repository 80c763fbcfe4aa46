// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>

namespace shape::internal {

/// The nearest point of a triangle to p, as weights of its corners; of a triangle without area, a
/// nearest point of its sides (Ericson 2005, section 5.1.5).
[[nodiscard]] Eigen::Vector3d nearest_in_triangle(const Eigen::Vector3d& p,
                                                  const Eigen::Vector3d& a,
                                                  const Eigen::Vector3d& b,
                                                  const Eigen::Vector3d& c);

} // namespace shape::internal
