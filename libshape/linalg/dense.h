// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>

namespace shape {

/// Row-major matrix; used where a row is one mesh, one observation or one mode.
using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

} // namespace shape
