// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <vector>

#include "libshape/linalg/lanes.h"
#include "libshape/linalg/sparse_cholesky.h"

namespace shape {

/// The factor of a SparseCholesky in single precision, for preconditioners: solves for three
/// right-hand sides at once, several times faster than SparseCholesky::solve().
///
/// The elimination tree is cut into subtrees that threads work on side by side; above them is the
/// trunk. Same bits for any number of threads.
class SinglePrecisionSolve
{
public:
    explicit SinglePrecisionSolve(const SparseCholesky& cholesky);

    /// Solves A X = B about as exactly as float allows.
    /// @param rhs  A row of B in each column.
    /// @param solution  Overwritten, the same layout.
    /// @throws InvalidInput if rhs has another number of columns than A.
    /// Safe to call concurrently.
    void solve(const LaneVectors& rhs, LaneVectors& solution) const;

private:
    /// A dense block of columns of the factor. Rows of the diagonal block first, then those below.
    struct Supernode
    {
        int first_column; ///< In its subtree.
        int columns;
        int first_row; ///< Into rows_: rows below the diagonal block.
        int rows;
        std::size_t
            diagonal;      ///< Into values_: columns by columns, row by row, the pivots inverted.
        std::size_t below; ///< Into values_: rows by columns, row by row.
    };
    /// Columns that follow each other, numbered from 0, and after them the rows that they reach in
    /// the trunk.
    struct Subtree
    {
        int first_column;
        int columns;
        std::size_t first_supernode;
        std::size_t end_supernode;
        std::vector<int> reached; ///< Rows of the trunk; none for the trunk itself.
    };

    void forward(const Subtree& subtree, Lanes* x) const;
    void backward(const Subtree& subtree, Lanes* x) const;

    std::vector<int> permutation_;
    std::vector<Subtree> subtrees_; ///< The last one is the trunk.
    std::vector<Supernode> supernodes_;
    std::vector<int> rows_; ///< In the numbers of the subtree.
    std::vector<float> values_;
};

} // namespace shape
