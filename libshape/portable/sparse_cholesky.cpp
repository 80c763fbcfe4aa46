// SPDX-License-Identifier: MIT

#include "libshape/linalg/sparse_cholesky.h"

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/linalg/simplicial_cholesky.h"

namespace shape::internal {

// What the library does with small matrices, for all: here are small ones, and few.

struct SparseCholesky::Factor
{
    SimplicialCholesky cholesky;
    Eigen::Index size;
    Eigen::Index entries;

    explicit Factor(const SparseMatrix& matrix)
        : cholesky(matrix), size(matrix.rows()), entries(matrix.nonZeros())
    {
    }
};

SparseCholesky::SparseCholesky(const SparseMatrix& matrix, Ordering)
{
    if (matrix.rows() != matrix.cols() || matrix.rows() == 0 || !matrix.isCompressed())
        throw InvalidInput(join("sparse Cholesky factorisation: the matrix is ", matrix.rows(),
                                " by ", matrix.cols(), ", must be square, not empty, compressed"));
    factor_ = std::make_unique<Factor>(matrix);
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
    factor_->cholesky.refactor(matrix);
}

Eigen::MatrixXd SparseCholesky::solve(const Eigen::MatrixXd& rhs) const
{
    if (rhs.rows() != size())
        throw InvalidInput(
            join("solve: the right-hand side has ", rhs.rows(), " rows, the matrix ", size()));
    return factor_->cholesky.solve(rhs);
}

Eigen::Index SparseCholesky::size() const
{
    return factor_->size;
}

SupernodalFactor SparseCholesky::factor() const
{
    throw InvalidInput("the factor of a simplicial factorisation has no supernodes");
}

std::size_t SparseCholesky::nonzeros() const
{
    return factor_->cholesky.nonzeros();
}

} // namespace shape::internal
