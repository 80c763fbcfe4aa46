// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>

#include "libshape/linalg/dense.h"

namespace shape {

/// Mean of the rows of N by E data, E entries.
/// @throws InvalidInput if data has no row.
[[nodiscard]] Eigen::VectorXd mean_of_rows(const RowMatrix& data);

} // namespace shape
