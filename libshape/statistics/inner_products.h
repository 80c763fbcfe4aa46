// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>

#include "libshape/linalg/dense.h"

namespace shape {

/// Inner products X X^T of the rows of N by E data, N by N. Tests, classification and resampling
/// need no more of the observations: everything they do is the same for any N points with these.
/// Cost: N^2 E / 2 multiplications. Same bits for any thread count.
[[nodiscard]] Eigen::MatrixXd inner_products(const RowMatrix& data);

/// Inner products of the rows about their mean.
/// @throws InvalidInput if data has no row.
[[nodiscard]] Eigen::MatrixXd centred_inner_products(RowMatrix data);

/// Inner products about the mean of N points with these distances, -1/2 J D^2 J with the centring
/// matrix J (Gower 1966). If no points have them (distances of another kind) sums of squares are
/// still meaningful (Anderson 2001), eigenvalues < 0 may occur.
/// @throws InvalidInput as check_distances().
[[nodiscard]] Eigen::MatrixXd inner_products_of_distances(const Eigen::MatrixXd& distances);

} // namespace shape
