// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>

#include "libshape/linalg/dense.h"
#include "libshape/statistics/grouping.h"

namespace shape::internal {

/// The largest K so that the pooled covariance of groups of points is regular in their first K coordinates: about the
/// means of the groups each of these varies by more than 1e-12 of what it varies about that of all, and deviations along
/// it form an angle of more than 1e-7 [rad] with what those before it span.
/// @param points  N by any number, finite.
/// @param groups  Of the N points, none empty.
[[nodiscard]] Eigen::Index regular_coordinates(const RowMatrix& points, const Grouping& groups);

} // namespace shape::internal
