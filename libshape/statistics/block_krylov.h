// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "libshape/linalg/dense.h"
#include "libshape/statistics/pass_state_reader.h"

namespace shape::internal {

struct BlockKrylovOptions
{
    /// This many leading components are wanted; 0: as few as have the share `variance`. >= 0.
    Eigen::Index components = 0;
    /// This share of the variance is to be explained where `components` is 0; in (0, 1].
    double variance = 1.0;
    /// The relative error of each of their variances is at most this, as estimated, or what rounding leaves; in (0, 1).
    double tolerance = 1e-6;
    /// The random vectors of the start block are drawn with this seed.
    std::uint64_t seed = 1;
    /// What the bases, and rows that are multiplied together, may take [byte].
    std::uint64_t memory = 0;
};

/// @throws InvalidInput naming the first field that breaks its rule.
void check(const BlockKrylovOptions& options);

/// The leading principal components of N rows of E numbers that come by once a pass, in the same blocks
/// each time: block Lanczos method on the covariance C = X^T X of the centred rows, from a random
/// block of s vectors, or one that some rows give (Golub and Underwood 1977; Musco and Musco 2015), with full orthogonalisation and
/// restarts with the best s Ritz vectors where the bases fill the memory (Stathopoulos, Saad and Wu 1998).
/// One pass is one product with C.
///
/// A Ritz value t has the residual r; for the first m of them together, the errors are at most
///
///     min( r,  sum_(j <= m) r_j^2 / (t_m - t_(m+1)) ),
///
/// and each component has the least of these bounds over the m that include it. These may be far below what rounding
/// leaves: no error is reported as less than 4 epsilon t_1 / t_K, in which components of less than 1e-12 t_1, which
/// are rounding, do not count. Where that is above the tolerance, no further pass would bring it down.
class BlockKrylov
{
public:
    /// @throws LimitExceeded if the memory does not hold five blocks.
    BlockKrylov(Eigen::Index rows, Eigen::Index columns, const BlockKrylovOptions& options);

    /// Vectors of a block for this many components.
    [[nodiscard]] static Eigen::Index block_size(Eigen::Index components);
    /// Rows that a pass takes at a time: a power of two in [4, 256], of about 32 MiB if it can be.
    [[nodiscard]] static Eigen::Index tile_rows(Eigen::Index columns);

    /// Begins with the principal directions of some rows, and a few random ones for what these rows lack, instead
    /// of random ones alone: half a pass ahead, as C^(1/2) is. Their mean is the point about which the first
    /// pass takes its rows; without this, that is the mean of the first ones.
    /// @param sample  Spread over all rows; at most sample_rows() of them are worth while.
    void start_from(RowMatrix sample);
    /// As many as wait to be multiplied at most: their memory is there.
    [[nodiscard]] Eigen::Index sample_rows() const { return held_.rows(); }
    /// Takes the next rows of a pass.
    void add(Eigen::Index first, const RowMatrix& rows);
    /// Adds to the sums what add() has put off: rows are multiplied many at a time.
    void flush();
    /// What add() and flush() sum in this pass, 0 before it: where several processes have rows, the arrays of
    /// all of them must be added, after flush(), before it ends.
    [[nodiscard]] std::vector<std::span<double>> sums();
    /// @throws LimitExceeded if the memory cannot hold what the share of variance needs.
    void end_pass();

    // What the start does not span, no estimate of an error sees: a few rows far from all others, of which the
    // sample has none, may carry the largest components. So the rows that the first pass finds far from the start join it.

    /// Squared distances of all rows from the span of the start, after the first pass; 0 of rows that other processes
    /// have, whose arrays must be added.
    [[nodiscard]] std::span<double> residuals();
    /// By these, rows that are more than twice as far as the median, at most s, the farthest first.
    [[nodiscard]] std::vector<Eigen::Index> outlying_rows() const;
    /// Lets the principal directions of these rows, at most s / 4, be among what the second pass multiplies.
    void add_directions(RowMatrix rows);

    [[nodiscard]] bool is_complete() const { return is_complete_; }
    [[nodiscard]] int passes() const { return passes_; }
    [[nodiscard]] double error() const
    {
        return error_;
    } ///< Estimate of the largest relative error, never below what rounding leaves.

    [[nodiscard]] const Eigen::VectorXd& mean() const { return mean_; } ///< After the first pass.
    [[nodiscard]] double squared_norm() const
    {
        return squares_;
    }                                           ///< Of all centred rows, then too.
    [[nodiscard]] RowMatrix components() const; ///< K by E, orthonormal; when complete.

    void release(PassState& state); ///< Between passes: hands over what restore() takes back.
    void restore(PassStateReader& state);

private:
    void hold(const RowMatrix& rows, Eigen::Index first, Eigen::Index count);
    void measure_residuals(const RowMatrix& shares);
    void orthogonalise(RowMatrix& block, RowMatrix& projected) const;
    void judge(const Eigen::VectorXd& values, const Eigen::VectorXd& residuals);
    void restart(const Eigen::MatrixXd& vectors, const Eigen::VectorXd& values);

    Eigen::Index rows_;
    Eigen::Index columns_;
    BlockKrylovOptions options_;
    Eigen::Index size_;        ///< s.
    Eigen::Index most_blocks_; ///< Of the basis.
    Eigen::VectorXd mean_;     ///< In the first pass that of its first rows.
    Eigen::VectorXd sums_;
    double squares_ = 0.0;
    std::vector<RowMatrix>
        basis_; ///< E by s each; the product of the last one is taken in this pass.
    RowMatrix product_;
    RowMatrix held_; ///< Centred rows that wait to be multiplied, the first held_count_ of them.
    Eigen::Index held_count_ = 0;
    std::vector<Eigen::Index> held_numbers_; ///< Which rows these are.
    Eigen::VectorXd residuals_;              ///< N, of the first pass.
    RowMatrix projected_;                    ///< C in the basis.
    Eigen::MatrixXd ritz_vectors_;
    Eigen::Index wanted_ = 0; ///< K.
    int passes_ = 0;
    double error_ = 1.0;
    bool is_complete_ = false;
};

} // namespace shape::internal
