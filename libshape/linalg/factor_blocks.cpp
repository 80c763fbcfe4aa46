// SPDX-License-Identifier: MIT

#include "libshape/linalg/factor_blocks.h"

#include <bit>
#include <cmath>
#include <cstring>
#include <numeric>
#include <vector>

#include "libshape/base/bits.h"
#include "libshape/base/to_size.h"
#include "libshape/base/vectorised.h"

namespace shape::internal {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

// How a block is worked on. Of a block with columns L (a triangle) over B, forward substitution means
//
//     own = L^-1 own,   x -= B own (the new one),      that is   own, x += (L^-1, -B L^-1) own (the old one),
//
// and back substitution the same transposed. In memory, for 6 columns (triangle_step is 4):
//
//     L^-1   | a 0 0 0       |      values   a000 bb00 ccc0 dddd, eeeeee ffffff  the first rows are filled
//            | b b 0 0       |               up with zeros to 4 entries, the next to 6;
//            | c c c 0       |
//            | d d d d       |      then     gggggg hhhhhh ...  the rows of -B L^-1, row r of which belongs to
//            | e e e e e 0   |               the vector x[row[r]]
//            | f f f f f f   |
//     vectors   x y z 0  x y z 0   two in a register of eight floats
//
// It is not the plain substitution, in which every row waits for the one before: both ways are one product
// with a dense matrix of few columns. The vectors of all columns stay in registers, and the matrix is
// read once, from its first entry to the last one or back, which is what memory does fastest. A large
// factor costs nothing but this reading: 4 bytes an entry in float, 2 in bfloat16.

// Bytes before its use at which the matrix is fetched: a read from memory takes some 100 ns, in
// which blocks of tens of bytes a nanosecond are worked on.
constexpr int ahead = 4096;

/// Two vectors in one register, at any address of Lanes.
using Pair = float __attribute__((vector_size(32), aligned(16)));

/// As many vectors as a block has columns, two by two.
template <int columns>
struct Vectors
{
    Pair pairs[columns / 2 + 1]; // one more than there are: not all blocks have any
    Lanes odd;                   // the last one of an odd number
};

[[gnu::always_inline]] inline float value_of(float entry)
{
    return entry;
}
[[gnu::always_inline]] inline float value_of(Bfloat16 entry)
{
    return float_of(static_cast<std::uint32_t>(entry) << 16);
}

/// Adds two entries times a vector each.
[[gnu::always_inline]] inline void add_products(const float* entries, const Pair& vectors,
                                                Pair& sums)
{
    const float a = entries[0];
    const float b = entries[1];
    sums += Pair{a, a, a, a, b, b, b, b} * vectors;
}
/// The second entry ends in the first one instead of in zeros, which rounded() reckons with.
[[gnu::always_inline]] inline void add_products(const Bfloat16* entries, const Pair& vectors,
                                                Pair& sums)
{
    using Words = std::uint32_t __attribute__((vector_size(32)));
    std::uint32_t w = 0;
    if constexpr (std::endian::native == std::endian::little)
        std::memcpy(&w, entries, sizeof w); // compilers do not see that the other is this
    else
        w = entries[0] | static_cast<std::uint32_t>(entries[1]) << 16;
    sums +=
        reinterpret_cast<Pair>(Words{w, w, w, w, w, w, w, w} << Words{16, 16, 16, 16}) * vectors;
}

/// Row times vectors.
template <int columns, class Entry, class All>
[[gnu::always_inline]] inline Lanes product(const Entry* row, const All& vectors)
{
    Lanes sum{};
    if constexpr (columns > 1) {
        Pair both{};
        for (int k = 0; k < columns / 2; ++k)
            add_products(row + 2 * k, vectors.pairs[k], both);
        sum = __builtin_shufflevector(both, both, 0, 1, 2, 3) +
              __builtin_shufflevector(both, both, 4, 5, 6, 7);
    }
    if constexpr (columns % 2 == 1)
        sum += value_of(row[columns - 1]) * vectors.odd;
    return sum;
}

/// Adds to the vectors their entries of a row times what the row belongs to.
template <int columns, class Entry, class All>
[[gnu::always_inline]] inline void add_product(const Entry* row, const Lanes& x, All& vectors)
{
    const Pair twice = __builtin_shufflevector(x, x, 0, 1, 2, 3, 0, 1, 2, 3);
    for (int k = 0; k < columns / 2; ++k)
        add_products(row + 2 * k, twice, vectors.pairs[k]);
    if constexpr (columns % 2 == 1)
        vectors.odd += value_of(row[columns - 1]) * x;
}

/// Calls work for the rows of a triangle from `first` on: `triangle_step` rows are stored as long as the last of
/// them, and so on.
/// @param values  Those of the first row; ends behind the last one.
template <int columns, int first, class Entry, class Work>
[[gnu::always_inline]] inline void for_triangle(const Entry*& values, const Work& work)
{
    constexpr int filled = std::min(first + triangle_step, columns);
    for (int i = first; i < filled; ++i, values += filled)
        work.template operator()<filled>(i, values);
    if constexpr (filled < columns)
        for_triangle<columns, filled>(values, work);
}

/// The same in the opposite order, from the end of the values.
/// @tparam first  Of the last `triangle_step` rows.
template <int columns, int first, class Entry, class Work>
[[gnu::always_inline]] inline void for_triangle_down(const Entry*& values, const Work& work)
{
    constexpr int filled = std::min(first + triangle_step, columns);
    for (int i = filled; i-- > first;)
        work.template operator()<filled>(i, values -= filled);
    if constexpr (first > 0)
        for_triangle_down<columns, first - triangle_step>(values, work);
}

/// own = inverse of L times own, x += B' own.
template <int columns, class Entry>
[[gnu::always_inline]] inline void block_up(int rows, const int* row, const Entry* values,
                                            Lanes* own, Lanes* x)
{
    Vectors<columns> vectors;
    for (int k = 0; k < columns / 2; ++k)
        vectors.pairs[k] = reinterpret_cast<const Pair*>(own)[k];
    vectors.odd = own[columns - 1];
    for_triangle<columns, 0>(
        values, [&]<int filled>(int i, const Entry* entries)
                    __attribute__((always_inline)) { own[i] = product<filled>(entries, vectors); });
    for (int i = 0; i < rows; ++i, values += columns) {
        __builtin_prefetch(values + ahead / sizeof(Entry));
        x[row[i]] += product<columns>(values, vectors);
    }
}

/// own = transposed inverse of L times own + transposed B' times x.
template <int columns, class Entry>
[[gnu::always_inline]] inline void block_down(int rows, const int* row, const Entry* values,
                                              Lanes* own, const Lanes* x)
{
    Vectors<columns> vectors{};
    for (int i = rows; i-- > 0;) {
        values -= columns;
        __builtin_prefetch(values - ahead / sizeof(Entry));
        add_product<columns>(values, x[row[i]], vectors);
    }
    for_triangle_down<columns, (columns - 1) / triangle_step * triangle_step>(
        values, [&]<int filled>(int i, const Entry* entries) __attribute__((always_inline)) {
            add_product<filled>(entries, own[i], vectors);
        });
    for (int k = 0; k < columns / 2; ++k)
        reinterpret_cast<Pair*>(own)[k] = vectors.pairs[k];
    if constexpr (columns % 2 == 1)
        own[columns - 1] = vectors.odd;
}

/// Calls work<columns>() for a number of columns known only now.
template <int columns = 1, class Work>
[[gnu::always_inline]] inline void with_columns(int known, const Work& work)
{
    if (known == columns)
        work.template operator()<columns>();
    else if constexpr (columns < widest_block)
        with_columns<columns + 1>(known, work);
}

template <class Entry>
[[gnu::always_inline]] inline void all_up(const FactorBlock* block, const FactorBlock* end,
                                          const int* row, const Entry* values, Lanes* x)
{
    for (; block != end; row += block->rows, ++block)
        with_columns(
            block->columns, [&]<int columns>() __attribute__((always_inline)) {
                block_up<columns>(block->rows, row, values, x + block->first_column, x);
                values += stored_triangle(columns) + columns * block->rows;
            });
}

template <class Entry>
[[gnu::always_inline]] inline void all_down(const FactorBlock* first, const FactorBlock* block,
                                            const int* row, const Entry* values, Lanes* x)
{
    while (block-- != first) {
        row -= block->rows;
        with_columns(
            block->columns, [&]<int columns>() __attribute__((always_inline)) {
                block_down<columns>(block->rows, row, values, x + block->first_column, x);
                values -= stored_triangle(columns) + columns * block->rows;
            });
    }
}

/// The float nearest to value whose lower half is this one.
/// @param least  Takes the place of smaller values above a lower half, which alone would make a number
///     too small to calculate with at full speed.
float rounded(double value, std::uint32_t lower_half, double least)
{
    const bool vanishes = lower_half != 0 && std::abs(value) < least;
    const auto wanted = static_cast<float>(vanishes ? least : value);
    const std::uint32_t bits = bits_of(wanted) - lower_half + 0x8000U;
    return float_of((bits & 0xffff0000U) | lower_half);
}

} // namespace

SHAPE_VECTORISED void forward_substitute(const FactorBlock* block, const FactorBlock* end,
                                         const int* row, const float* values, Lanes* x)
{
    all_up(block, end, row, values, x);
}
SHAPE_VECTORISED void forward_substitute(const FactorBlock* block, const FactorBlock* end,
                                         const int* row, const Bfloat16* values, Lanes* x)
{
    all_up(block, end, row, values, x);
}

SHAPE_VECTORISED void back_substitute(const FactorBlock* first, const FactorBlock* end,
                                      const int* row, const float* values, Lanes* x)
{
    all_down(first, end, row, values, x);
}
SHAPE_VECTORISED void back_substitute(const FactorBlock* first, const FactorBlock* end,
                                      const int* row, const Bfloat16* values, Lanes* x)
{
    all_down(first, end, row, values, x);
}

Bfloat16 upper_half(double value)
{
    return static_cast<Bfloat16>(bits_of(static_cast<float>(value)) >> 16);
}

void round_to_halves(MatrixXd& matrix)
{
    const Eigen::VectorXd sizes = matrix.rowwise().squaredNorm();
    std::vector<Index> order(to_size(matrix.rows()));
    std::iota(order.begin(), order.end(), Index{0});
    std::stable_sort(order.begin(), order.end(),
                     [&](Index a, Index b) { return sizes[a] > sizes[b]; });
    const double least = 0x1p-40 * std::sqrt(sizes.size() > 0 ? sizes.maxCoeff() : 0.0);
    Eigen::VectorXd errors = Eigen::VectorXd::Zero(matrix.cols());
    for (const Index r : order) {
        std::uint32_t lower_half = 0;
        for (Index c = 0; c < matrix.cols(); ++c) {
            double& entry = matrix(r, c);
            const float value = rounded(entry == 0.0 ? 0.0 : entry + errors[c], lower_half, least);
            errors[c] += entry - value;
            entry = value;
            lower_half = c % 2 == 0 ? upper_half(value) : 0;
        }
    }
}

} // namespace shape::internal
