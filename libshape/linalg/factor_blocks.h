// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cstdint>

#include "libshape/linalg/lanes.h"

namespace shape::internal {

/// Consecutive columns of a Cholesky factor with the same pattern: a triangle L on top of a matrix B.
/// Solving upwards means
///
///     own = L^-1 own,   x -= B own (the new one),   that is   own, x += (L^-1, -B L^-1) own (the old one),
///
/// and solving downwards the same transposed. So both ways are one product with a dense matrix of few
/// columns, no row of which waits for the one before. The layout is drawn in factor_blocks.cpp.
struct FactorBlock
{
    int first_column; ///< Where its own vectors are.
    int columns;      ///< At most widest_block.
    int rows;         ///< B has this many.
};

inline constexpr int widest_block = 16; ///< For more columns there are no registers.

/// Stored are L^-1, row by row, as many rows of equal length at a time, then the rows of -B L^-1.
inline constexpr int triangle_step = 4;

/// Stored entries of a row of L^-1, and of all.
[[nodiscard]] constexpr int stored_row(int row, int columns)
{
    return std::min((row / triangle_step + 1) * triangle_step, columns);
}
[[nodiscard]] constexpr int stored_triangle(int columns)
{
    int size = 0;
    for (int row = 0; row < columns; ++row)
        size += stored_row(row, columns);
    return size;
}

/// The upper half of a float: its sign, exponent and eight binary digits.
using Bfloat16 = std::uint16_t;

/// Blocks one after the other, upwards.
/// @param row  Of B: which vectors they belong to.
/// @param values  Of the first block.
/// @param x  The vectors, in and out.
void forward_substitute(const FactorBlock* block, const FactorBlock* end, const int* row,
                        const float* values, Lanes* x);
void forward_substitute(const FactorBlock* block, const FactorBlock* end, const int* row,
                        const Bfloat16* values, Lanes* x);

/// Blocks from the last one to the first, downwards.
/// @param row, values  Behind those of the last block.
void back_substitute(const FactorBlock* first, const FactorBlock* end, const int* row,
                     const float* values, Lanes* x);
void back_substitute(const FactorBlock* first, const FactorBlock* end, const int* row,
                     const Bfloat16* values, Lanes* x);

/// Rounds the entries of a matrix to what upper_half() keeps of them; but those of odd columns end in the
/// bits of the one before instead of in zeros, which is how they are read. Every rounding error is
/// passed on to the next smaller row, so that the sums of columns stay.
void round_to_halves(Eigen::MatrixXd& matrix);

/// Of the float nearest to value.
[[nodiscard]] Bfloat16 upper_half(double value);

} // namespace shape::internal
