// SPDX-License-Identifier: MIT

#include "libshape/linalg/simplicial_cholesky.h"

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/to_size.h"

namespace shape::internal {

SimplicialCholesky::SimplicialCholesky(const SparseMatrix& matrix)
{
    factor_.analyzePattern(matrix);
    refactor(matrix);
}

void SimplicialCholesky::refactor(const SparseMatrix& matrix)
{
    factor_.factorize(matrix);
    if (factor_.info() != Eigen::Success)
        throw NumericalError(join("sparse Cholesky factorisation: the matrix of size ",
                                  matrix.rows(), " is not positive definite"));
}

Eigen::MatrixXd SimplicialCholesky::solve(const Eigen::MatrixXd& rhs) const
{
    if (factor_.info() != Eigen::Success)
        throw NumericalError("solve: the last factorisation failed");
    return factor_.solve(rhs);
}

std::size_t SimplicialCholesky::nonzeros() const
{
    return to_size(factor_.matrixL().nestedExpression().nonZeros());
}

} // namespace shape::internal
