// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

namespace shape::internal {

/// An off-diagonal entry of a symmetric matrix.
struct SymmetricEntry
{
    int row = 0; ///< > column
    int column = 0;
    double value = 0.0;
};

/// Factorisations A = L D L^T of many small sparse symmetric positive definite matrices, one after
/// the other in a few arrays. Each is eliminated in its given order. For thousands of systems that
/// are solved over and over; a single large one is better served by SparseCholesky.
class PackedCholesky
{
public:
    /// Factors one more matrix and returns its index.
    /// @param entries  Below the diagonal, each at most once.
    /// @throws NumericalError if a pivot is not positive.
    /// Cost: O(sum over the columns of L of their squared number of entries).
    std::size_t add(const Eigen::VectorXd& diagonal, std::span<const SymmetricEntry> entries);

    /// Solves A X = B in place for four columns; x has one row (point) per unknown.
    void solve(std::size_t index, Eigen::Vector4d* x) const;

    /// Entries of all factors.
    [[nodiscard]] std::size_t nonzeros() const { return values_.size(); }

private:
    struct Factor
    {
        int size = 0;
        std::size_t columns = 0; ///< Into column_ends_ and inverse_pivots_.
        std::size_t entries = 0; ///< Into rows_ and values_.
    };
    std::vector<Factor> factors_;
    std::vector<int> column_ends_; ///< Relative to the factor's first entry.
    std::vector<double> inverse_pivots_;
    std::vector<int> rows_;
    std::vector<double> values_;
};

} // namespace shape::internal
