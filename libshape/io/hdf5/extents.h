// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <vector>

namespace shape::internal {

/// Extents of a dataset; none for a single value.
using Extents = std::vector<Eigen::Index>;

/// In expected extents: any length > 0.
inline constexpr Eigen::Index any_length = -1;

} // namespace shape::internal
