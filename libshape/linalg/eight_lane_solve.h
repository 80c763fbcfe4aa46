// SPDX-License-Identifier: MIT

#pragma once

#include <vector>

#include "libshape/linalg/eight_lanes.h"
#include "libshape/linalg/sparse_cholesky.h"

namespace shape::internal {

/// Factorisation of a small sparse symmetric positive definite matrix that serves 24 right-hand sides
/// at once in single precision: the three coordinates of eight problems.
class EightLaneSolve
{
public:
    /// @param matrix  Its lower triangle is read. The order of elimination is found here.
    /// @throws NumericalError if it is not numerically positive definite.
    explicit EightLaneSolve(const SparseMatrix& matrix);

    /// Solves A X = B in place; x has one point per unknown.
    /// Safe to call concurrently.
    void solve(EightLanePoints& x) const;

private:
    // The factor by columns in the order of elimination; rows are named as in the matrix.
    std::vector<int> order_;
    std::vector<int> begins_;
    std::vector<int> rows_;
    std::vector<float> values_;
    std::vector<float> inverse_pivots_;
};

} // namespace shape::internal
