// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <vector>

#include "libshape/base/bytes.h"
#include "libshape/linalg/factor_blocks.h"
#include "libshape/linalg/lanes.h"
#include "libshape/linalg/sparse_cholesky.h"

namespace shape::internal {

/// The factor of a SparseCholesky in single precision, for preconditioners: solves for three
/// right-hand sides at once, many times faster than SparseCholesky::solve().
///
/// The elimination tree is cut into parts of three tiers: leaf subtrees, the middle ones above
/// them, and the root. Threads work on the parts of a tier side by side. Same bits for any number of threads.
class SinglePrecisionSolve
{
public:
    explicit SinglePrecisionSolve(const SparseCholesky& cholesky);

    /// What write() wrote: the same bits, and nothing is factorised.
    /// @throws InvalidInput if the bytes are damaged.
    explicit SinglePrecisionSolve(ByteReader& from);
    void write(ByteWriter& to) const;

    /// Rows of A.
    [[nodiscard]] Eigen::Index size() const { return std::ssize(permutation_); }

    /// Solves A X = B about as exactly as float allows.
    /// @param rhs  A row of B in each column.
    /// @param solution  Overwritten, the same layout.
    /// @param workspace  Overwritten; worth keeping for the next call.
    /// @return The sum of all products of an entry of B and the same one of X.
    /// @throws InvalidInput if rhs has another number of columns than A.
    /// Safe to call concurrently, with a workspace each.
    double solve(const LaneVectors& rhs, LaneVectors& solution, LaneVectors& workspace) const;

    /// About that: every entry of the factor is rounded to eight binary digits, which halves the memory
    /// read, all that a large factor costs. For preconditioning; a symmetric operator. Errors of
    /// rounding are passed on in each column, so that of a graph's Laplacian another one remains, every
    /// weight of which is about the same: it preconditions as well as the factor itself.
    double precondition(const LaneVectors& rhs, LaneVectors& solution,
                        LaneVectors& workspace) const;

private:
    struct Part
    {
        std::size_t first_column = 0; ///< Into permutation_.
        std::size_t columns = 0;
        std::size_t reached = 0; ///< Rows of the parts above that follow in the workspace.
        std::size_t place = 0;   ///< In the workspace.
        std::size_t above = 0;   ///< Into reached_rows_: where the part above has them.
        std::size_t first_block = 0;
        std::size_t end_block = 0;
        std::size_t first_row = 0; ///< Into rows_.
        std::size_t end_row = 0;
        std::size_t first_value = 0; ///< Into values_.
        std::size_t end_value = 0;
        std::size_t parent = 0; ///< The part above; itself where there is none.
        std::vector<std::size_t> children;

        /// All of it but the children.
        [[nodiscard]] auto numbers()
        {
            return std::array{&first_column, &columns,     &reached,   &place,
                              &above,        &first_block, &end_block, &first_row,
                              &end_row,      &first_value, &end_value, &parent};
        }
    };

    void check() const;
    template <class Number>
    void add_blocks(const SupernodalFactor& f, std::size_t supernode, const Number& number);
    template <class Entry>
    void forward(const Part& part, const Entry* values, const Lanes* rhs, Lanes* workspace) const;
    template <class Entry>
    double backward(const Part& part, const Entry* values, const Lanes* rhs, Lanes* workspace,
                    Lanes* solution) const;
    template <class Entry>
    double solve(const Entry* values, const LaneVectors& rhs, LaneVectors& solution,
                 LaneVectors& workspace) const;

    std::vector<int> permutation_;
    std::vector<Part> parts_;            ///< Leaf, middle and root subtrees.
    std::array<std::size_t, 3> tiers_{}; ///< Where each ends.
    std::vector<FactorBlock> blocks_;
    std::vector<int> rows_; ///< The rows of every B, in the numbers of the part.
    std::vector<int> reached_rows_;
    std::vector<float> values_;
    std::vector<Bfloat16> halves_; ///< The same, rounded.
    std::size_t places_ = 0;       ///< In all.
    float scale_ = 1.0F;           ///< The inverse as stored times this is that of A.
};

} // namespace shape::internal
