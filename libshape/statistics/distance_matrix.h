// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>

#include "libshape/linalg/dense.h"

namespace shape {

/// Euclidean distances between the rows of N by E data, N by N: symmetric, 0 on the diagonal.
/// Taken from the differences themselves: small distances keep their digits.
/// @throws InvalidInput if an entry is not finite.
/// Cost: N^2 E / 2 differences. Same bits for any thread count.
[[nodiscard]] Eigen::MatrixXd distance_matrix(const RowMatrix& data);

/// @throws InvalidInput unless the matrix is square, symmetric, finite, >= 0, and 0 on the diagonal.
void check_distances(const Eigen::MatrixXd& distances);

} // namespace shape
