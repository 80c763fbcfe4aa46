// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/QR>

#include "libshape/base/random.h"

namespace shape::test {
using namespace internal;

/// Independent standard normal entries.
[[nodiscard]] inline Eigen::MatrixXd random_matrix(Eigen::Index rows, Eigen::Index columns,
                                                   unsigned seed)
{
    Random random(seed);
    Eigen::MatrixXd matrix(rows, columns);
    for (double& entry : matrix.reshaped())
        entry = random.normal();
    return matrix;
}

/// A square matrix with orthonormal columns.
[[nodiscard]] inline Eigen::MatrixXd random_orthogonal(Eigen::Index size, unsigned seed)
{
    return Eigen::HouseholderQR<Eigen::MatrixXd>(random_matrix(size, size, seed)).householderQ();
}

} // namespace shape::test
