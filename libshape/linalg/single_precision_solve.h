// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <vector>

#include "libshape/linalg/sparse_cholesky.h"

namespace shape {

/// The factor of a SparseCholesky in single precision, for preconditioners: solves for three
/// right-hand sides at once, several times faster than SparseCholesky::solve().
class SinglePrecisionSolve
{
public:
    explicit SinglePrecisionSolve(const SparseCholesky& cholesky);

    /// Solves A X = B about as exactly as float allows.
    /// @param rhs  #rows by 3, row by row.
    /// Safe to call concurrently.
    [[nodiscard]] Eigen::VectorXd solve(const Eigen::VectorXd& rhs) const;

private:
    struct Supernode
    {
        int first_column;
        int columns;
        int first_row; ///< Into rows_: rows below the diagonal block.
        int rows;
        std::size_t diagonal; ///< Into values_: columns by columns, row by row, the pivots inverted.
        std::size_t below;    ///< Into values_: rows by columns, row by row.
    };
    std::vector<int> permutation_;
    std::vector<Supernode> supernodes_;
    std::vector<int> rows_;
    std::vector<float> values_;
};

} // namespace shape
