// SPDX-License-Identifier: MIT

#include "libshape/linalg/eight_lane_solve.h"

#include <Eigen/SparseCholesky>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/to_size.h"
#include "libshape/base/vectorised.h"

namespace shape::internal {
namespace {

// Solves L L^T X = B for 24 columns: three coordinates of eight problems. In memory the factor by columns in
// the order of elimination, each entry one float for all 24, and the unknowns eight to a register:
//
//     values_   l21 l31 .. of column 0,  l32 ..  of column 1, ...
//     x         x: p0 p1 .. p7   y: p0 .. p7   z: p0 .. p7   of unknown 0,  of unknown 1, ...
//
// It is the plain substitution, column by column; what is not plain is its number: each index and entry is
// read once for 24 multiplications in three registers. Blocks as in factor_blocks.cpp would not pay:
// regions are small, and so
// are the supernodes of their factors.

SHAPE_VECTORISED void substitute(int size, const int* order, const int* begins, const int* rows,
                                 const float* values, const float* inverse_pivots,
                                 EightLanePoint* __restrict x)
{
    for (int j = 0; j < size; ++j) {
        const EightLanePoint known = inverse_pivots[j] * x[order[j]];
        x[order[j]] = known;
        for (int p = begins[j]; p < begins[j + 1]; ++p)
            x[rows[p]] = x[rows[p]] - values[p] * known;
    }
    for (int j = size - 1; j >= 0; --j) {
        EightLanePoint sum = x[order[j]];
        for (int p = begins[j]; p < begins[j + 1]; ++p)
            sum = sum - values[p] * x[rows[p]];
        x[order[j]] = inverse_pivots[j] * sum;
    }
}

} // namespace

EightLaneSolve::EightLaneSolve(const SparseMatrix& matrix)
{
    const Eigen::SimplicialLLT<SparseMatrix> cholesky(matrix);
    if (cholesky.info() != Eigen::Success)
        throw NumericalError(join("Cholesky factorisation of a matrix of size ", matrix.rows(),
                                  ": it is not positive definite"));
    const auto size = to_size(matrix.rows());
    order_.resize(size);
    for (std::size_t i = 0; i < size; ++i)
        order_[to_size(cholesky.permutationP().indices()[static_cast<int>(i)])] =
            static_cast<int>(i);
    const SparseMatrix factor = cholesky.matrixL();
    for (int j = 0; j < matrix.cols(); ++j) {
        begins_.push_back(static_cast<int>(rows_.size()));
        for (SparseMatrix::InnerIterator entry(factor, j); entry; ++entry) {
            const auto value = static_cast<float>(entry.value());
            if (entry.row() == j) {
                inverse_pivots_.push_back(1.0F / value);
            } else {
                rows_.push_back(order_[to_size(entry.row())]);
                values_.push_back(value);
            }
        }
    }
    begins_.push_back(static_cast<int>(rows_.size()));
}

void EightLaneSolve::solve(EightLanePoints& x) const
{
    substitute(static_cast<int>(order_.size()), order_.data(), begins_.data(), rows_.data(),
               values_.data(), inverse_pivots_.data(), x.data());
}

} // namespace shape::internal
