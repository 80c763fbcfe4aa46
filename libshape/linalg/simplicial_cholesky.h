// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/SparseCholesky>

#include "libshape/linalg/sparse_cholesky.h"

namespace shape::internal {

/// What SparseCholesky does with small matrices: Eigen's factorisation, column by column. For those it is as
/// fast as CHOLMOD, and has the same bits wherever there is Eigen. Callers check sizes.
class SimplicialCholesky
{
public:
    /// @throws NumericalError if the matrix is not numerically positive definite; so do those below.
    explicit SimplicialCholesky(const SparseMatrix& matrix);

    void refactor(const SparseMatrix& matrix);
    [[nodiscard]] Eigen::MatrixXd solve(const Eigen::MatrixXd& rhs) const;
    [[nodiscard]] std::size_t nonzeros() const; ///< Of the factor.

private:
    Eigen::SimplicialLLT<SparseMatrix> factor_;
};

} // namespace shape::internal
