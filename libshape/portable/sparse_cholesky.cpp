// SPDX-License-Identifier: MIT

#include "libshape/linalg/sparse_cholesky.h"
#include "libshape/base/to_size.h"

#include <Eigen/SparseCholesky>

#include "libshape/base/error.h"
#include "libshape/base/format.h"

namespace shape::internal {

// Eigen's simplicial factorisation, for what is small or made anew for every mesh.

struct SparseCholesky::Factor
{
    Eigen::SimplicialLLT<SparseMatrix> cholesky;
    Eigen::Index entries = 0;

    void factorise(const SparseMatrix& matrix)
    {
        cholesky.factorize(matrix);
        if (cholesky.info() != Eigen::Success)
            throw NumericalError(join("sparse Cholesky factorisation: the matrix of size ",
                                      matrix.rows(), " is not positive definite"));
    }
};

SparseCholesky::SparseCholesky(const SparseMatrix& matrix, Ordering)
    : factor_(std::make_unique<Factor>())
{
    if (matrix.rows() != matrix.cols() || matrix.rows() == 0 || !matrix.isCompressed())
        throw InvalidInput(join("sparse Cholesky factorisation: the matrix is ", matrix.rows(),
                                " by ", matrix.cols(), ", must be square, not empty, compressed"));
    factor_->entries = matrix.nonZeros();
    factor_->cholesky.analyzePattern(matrix);
    factor_->factorise(matrix);
}

SparseCholesky::~SparseCholesky() = default;
SparseCholesky::SparseCholesky(SparseCholesky&&) noexcept = default;
SparseCholesky& SparseCholesky::operator=(SparseCholesky&&) noexcept = default;

void SparseCholesky::refactor(const SparseMatrix& matrix)
{
    if (matrix.rows() != size() || matrix.cols() != size() ||
        matrix.nonZeros() != factor_->entries || !matrix.isCompressed())
        throw InvalidInput(join("refactor: the matrix has ", matrix.rows(), " rows and ",
                                matrix.nonZeros(), " entries, the pattern has ", size(), " and ",
                                factor_->entries));
    factor_->factorise(matrix);
}

Eigen::MatrixXd SparseCholesky::solve(const Eigen::MatrixXd& rhs) const
{
    if (rhs.rows() != size())
        throw InvalidInput(
            join("solve: the right-hand side has ", rhs.rows(), " rows, the matrix ", size()));
    if (factor_->cholesky.info() != Eigen::Success)
        throw NumericalError("solve: the last factorisation failed");
    return factor_->cholesky.solve(rhs);
}

Eigen::Index SparseCholesky::size() const
{
    return factor_->cholesky.rows();
}

SupernodalFactor SparseCholesky::factor() const
{
    throw InvalidInput("the factor of a simplicial factorisation has no supernodes");
}

std::size_t SparseCholesky::nonzeros() const
{
    return to_size(factor_->cholesky.matrixL().nestedExpression().nonZeros());
}

} // namespace shape::internal
