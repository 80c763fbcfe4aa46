// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <memory>
#include <span>

namespace shape::internal {

using SparseMatrix = Eigen::SparseMatrix<double, Eigen::ColMajor, int>;

/// Fill-reducing ordering of a sparse factorisation.
enum class Ordering
{
    MinimumDegree, ///< AMD: quick to find; small systems (without supernodes below 3000 rows), or
                   ///< systems factored once.
    NestedDissection, ///< METIS: less fill on large meshes; worth it when factored repeatedly.
};

/// The factor of a SparseCholesky as it is stored, for solvers of another kind. Row i of the factor
/// belongs to row permutation[i] of the matrix. Supernode s has the columns first_columns[s] to
/// first_columns[s + 1] and a dense block of values, column by column: its rows, of which the
/// first are the columns themselves, are rows[first_rows[s]] to rows[first_rows[s + 1]].
struct SupernodalFactor
{
    std::span<const int> permutation;
    std::span<const int> first_columns; ///< One more than supernodes, as the next two.
    std::span<const int> first_rows;
    std::span<const int> first_values;
    std::span<const int> rows;
    const double* values = nullptr;
};

/// Kept factorisation A = L L^T of a symmetric positive definite matrix (supernodal, CHOLMOD; small ones
/// in MinimumDegree by SimplicialCholesky).
///
/// The pattern is analysed once; refactor() takes other values on the same pattern. Same bits for
/// any thread count: BLAS runs in one thread.
class SparseCholesky
{
public:
    /// @param matrix  Square; only its lower triangle is read.
    /// @throws InvalidInput if matrix is not square, empty or not compressed.
    /// @throws NumericalError if it is not numerically positive definite.
    explicit SparseCholesky(const SparseMatrix& matrix,
                            Ordering ordering = Ordering::NestedDissection);
    ~SparseCholesky();
    SparseCholesky(SparseCholesky&&) noexcept;
    SparseCholesky& operator=(SparseCholesky&&) noexcept;

    /// Factors a matrix of the same pattern anew.
    /// @throws InvalidInput if the pattern has another size or count of entries.
    /// @throws NumericalError if it is not numerically positive definite.
    void refactor(const SparseMatrix& matrix);

    /// Solves A X = B for all columns of B at once; #rows by k, any k.
    /// Safe to call concurrently.
    /// @throws InvalidInput if B has another number of rows.
    /// @throws NumericalError if the last refactor() failed.
    [[nodiscard]] Eigen::MatrixXd solve(const Eigen::MatrixXd& rhs) const;

    [[nodiscard]] Eigen::Index size() const;

    /// A view, valid until the next refactor().
    /// @throws InvalidInput if the factor has no supernodes.
    [[nodiscard]] SupernodalFactor factor() const;

    /// Entries of the factor.
    [[nodiscard]] std::size_t nonzeros() const;

private:
    struct Factor;
    std::unique_ptr<Factor> factor_;
};

} // namespace shape::internal
