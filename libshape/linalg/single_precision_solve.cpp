// SPDX-License-Identifier: MIT

#include "libshape/linalg/single_precision_solve.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <numeric>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/threads.h"
#include "libshape/base/vectorised.h"

namespace shape {
namespace {

using Block = SinglePrecisionSolve::Block;
using FloatHalf = SinglePrecisionSolve::FloatHalf;
using Eigen::Index;
using Eigen::MatrixXd;

// How a block is worked on. Of a block with columns L (a triangle) over B, solving upwards means
//
//     own = L^-1 own,   x -= B own (the new one),      that is   own, x += (L^-1, -B L^-1) own (the old one),
//
// and solving downwards the same transposed. So both ways are one product with a dense matrix of few
// columns, row by row, and no row waits for the one before. The vectors of all columns stay in
// registers, two in each; the matrix is read once, from its first entry to the last one or back,
// which is what memory does fastest.

constexpr int widest = 16;  // columns of a block, for which there are registers
constexpr int step = 4;     // rows of the triangle that are stored equally long
constexpr int ahead = 4096; // bytes: how far before its use the matrix is fetched

std::size_t index(int i)
{
    return static_cast<std::size_t>(i);
}

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
[[gnu::always_inline]] inline float value_of(FloatHalf entry)
{
    return std::bit_cast<float>(static_cast<std::uint32_t>(entry) << 16);
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
[[gnu::always_inline]] inline void add_products(const FloatHalf* entries, const Pair& vectors,
                                                Pair& sums)
{
    using Words = std::uint32_t __attribute__((vector_size(32)));
    std::uint32_t w;
    std::memcpy(&w, entries, sizeof w);
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

/// Calls work for the rows of a triangle from `first` on: `step` rows are stored as long as the last of
/// them, and so on.
/// @param values  Those of the first row; ends behind the last one.
template <int columns, int first, class Entry, class Work>
[[gnu::always_inline]] inline void for_triangle(const Entry*& values, const Work& work)
{
    constexpr int filled = std::min(first + step, columns);
    for (int i = first; i < filled; ++i, values += filled)
        work.template operator()<filled>(i, values);
    if constexpr (filled < columns)
        for_triangle<columns, filled>(values, work);
}

/// The same in the opposite order, from the end of the values.
/// @tparam first  Of the last `step` rows.
template <int columns, int first, class Entry, class Work>
[[gnu::always_inline]] inline void for_triangle_down(const Entry*& values, const Work& work)
{
    constexpr int filled = std::min(first + step, columns);
    for (int i = filled; i-- > first;)
        work.template operator()<filled>(i, values -= filled);
    if constexpr (first > 0)
        for_triangle_down<columns, first - step>(values, work);
}

/// Its stored entries.
constexpr int triangle_size(int columns)
{
    int size = 0;
    for (int i = 0; i < columns; ++i)
        size += std::min((i / step + 1) * step, columns);
    return size;
}

/// own = inverse of L times own, x += B' own.
template <int columns, class Entry>
[[gnu::always_inline]] inline void forward_block(int rows, const int* row, const Entry* values,
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
[[gnu::always_inline]] inline void backward_block(int rows, const int* row, const Entry* values,
                                                  Lanes* own, const Lanes* x)
{
    Vectors<columns> vectors{};
    for (int i = rows; i-- > 0;) {
        values -= columns;
        __builtin_prefetch(values - ahead / sizeof(Entry));
        add_product<columns>(values, x[row[i]], vectors);
    }
    for_triangle_down<columns, (columns - 1) / step * step>(
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
    else if constexpr (columns < widest)
        with_columns<columns + 1>(known, work);
}

template <class Entry>
[[gnu::always_inline]] inline void all_forward(const Block* block, const Block* end, const int* row,
                                               const Entry* values, Lanes* x)
{
    for (; block != end; row += block->rows, ++block)
        with_columns(
            block->columns, [&]<int columns>() __attribute__((always_inline)) {
                forward_block<columns>(block->rows, row, values, x + block->first_column, x);
                values += triangle_size(columns) + columns * block->rows;
            });
}

template <class Entry>
[[gnu::always_inline]] inline void all_backward(const Block* first, const Block* block,
                                                const int* row, const Entry* values, Lanes* x)
{
    while (block-- != first) {
        row -= block->rows;
        with_columns(
            block->columns, [&]<int columns>() __attribute__((always_inline)) {
                backward_block<columns>(block->rows, row, values, x + block->first_column, x);
                values -= triangle_size(columns) + columns * block->rows;
            });
    }
}

/// All blocks of a part upwards. The rows above the part end as what is to be added to them.
SHAPE_VECTORISED void forward_blocks(const Block* block, const Block* end, const int* row,
                                     const float* values, Lanes* x)
{
    all_forward(block, end, row, values, x);
}
SHAPE_VECTORISED void forward_blocks(const Block* block, const Block* end, const int* row,
                                     const FloatHalf* values, Lanes* x)
{
    all_forward(block, end, row, values, x);
}

/// All blocks of a part downwards.
/// @param row, values  Behind the last one.
SHAPE_VECTORISED void backward_blocks(const Block* first, const Block* block, const int* row,
                                      const float* values, Lanes* x)
{
    all_backward(first, block, row, values, x);
}
SHAPE_VECTORISED void backward_blocks(const Block* first, const Block* block, const int* row,
                                      const FloatHalf* values, Lanes* x)
{
    all_backward(first, block, row, values, x);
}

/// Parts of the elimination tree, the lower tiers first: each a subtree less the parts below.
struct Cut
{
    std::vector<std::size_t> part_of_column; ///< Of the factor.
    std::vector<std::size_t> parent;         ///< Of every part; itself at a root.
    std::array<std::size_t, 3> tiers{};      ///< Where branches, limbs and the trunk end.
};

/// Branches are the largest subtrees with at most a sixteenth of the factor's entries, limbs those
/// with at most 6/10. All is trunk where the factor is too small to be worth the hand-over.
Cut cut(const SupernodalFactor& f)
{
    const std::size_t count = f.first_columns.size() - 1;
    std::vector<std::size_t> supernode_of(f.permutation.size());
    std::vector<std::size_t> above(count);
    std::vector<double> entries(count); // of the subtree
    for (std::size_t s = 0; s < count; ++s)
        std::fill(supernode_of.begin() + f.first_columns[s],
                  supernode_of.begin() + f.first_columns[s + 1], s);
    for (std::size_t s = 0; s < count; ++s) {
        const int next = f.first_rows[s] + f.first_columns[s + 1] - f.first_columns[s];
        above[s] = next == f.first_rows[s + 1] ? s : supernode_of[index(f.rows[index(next)])];
        entries[s] += f.first_values[s + 1] - f.first_values[s];
        if (above[s] != s)
            entries[above[s]] += entries[s];
    }
    const double all = f.first_values.back();
    constexpr double worth = 1 << 17;
    const auto tier = [&](std::size_t s) -> std::size_t {
        return all < worth ? 2 : entries[s] <= all / 16.0 ? 0 : entries[s] <= 0.6 * all ? 1 : 2;
    };

    Cut cut;
    std::vector<std::size_t> part(count);
    std::vector<std::size_t> tops; // of the parts
    for (const std::size_t t : {0, 1}) {
        for (std::size_t s = 0; s < count; ++s)
            if (tier(s) == t && (above[s] == s || tier(above[s]) != t)) {
                part[s] = tops.size();
                tops.push_back(s);
            }
        cut.tiers[t] = tops.size();
    }
    const std::size_t trunk = tops.size();
    cut.tiers[2] = trunk + 1;
    for (std::size_t s = count; s-- > 0;)
        if (tier(s) == 2)
            part[s] = trunk;
        else if (above[s] != s && tier(above[s]) == tier(s))
            part[s] = part[above[s]];
    for (const std::size_t top : tops)
        cut.parent.push_back(part[above[top]]);
    cut.parent.push_back(trunk);
    for (const std::size_t s : supernode_of)
        cut.part_of_column.push_back(part[s]);
    return cut;
}

FloatHalf upper_half(double value)
{
    return static_cast<FloatHalf>(std::bit_cast<std::uint32_t>(static_cast<float>(value)) >> 16);
}

/// The float nearest to value whose lower half is this one.
/// @param least  Takes the place of smaller values above a lower half, which alone would make a number
///     too small to calculate with at full speed.
float rounded(double value, std::uint32_t lower_half, double least)
{
    const bool vanishes = lower_half != 0 && std::abs(value) < least;
    const auto wanted = static_cast<float>(vanishes ? least : value);
    const std::uint32_t bits = std::bit_cast<std::uint32_t>(wanted) - lower_half + 0x8000U;
    return std::bit_cast<float>((bits & 0xffff0000U) | lower_half);
}

/// Rounds a matrix to halves of floats, as add_products() reads them. Every rounding error is passed on
/// to the next smaller row, so that the sums of columns stay.
void round_to_halves(MatrixXd& matrix)
{
    const Eigen::VectorXd sizes = matrix.rowwise().squaredNorm();
    std::vector<Index> order(static_cast<std::size_t>(matrix.rows()));
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

} // namespace

SinglePrecisionSolve::SinglePrecisionSolve(const SparseCholesky& cholesky)
{
    const SupernodalFactor f = cholesky.factor();
    // Entries of inverses of about 1, by a power of two: the same bits in any unit that is one.
    scale_ = std::ldexp(1.0F, -2 * std::ilogb(f.values[0]));
    const Cut parts = cut(f);
    const auto part_of = [&](int column) { return parts.part_of_column[index(column)]; };
    tiers_ = parts.tiers;
    parts_.resize(tiers_.back());

    // Numbers in the parts: columns first, then the rows that are reached.
    const std::size_t size = f.permutation.size();
    std::vector<std::vector<int>> columns(parts_.size());
    std::vector<std::vector<int>> reached(parts_.size());
    std::vector<std::vector<std::size_t>> supernodes(parts_.size());
    for (std::size_t s = 0; s + 1 < f.first_columns.size(); ++s) {
        const std::size_t p = part_of(f.first_columns[s]);
        supernodes[p].push_back(s);
        for (int c = f.first_columns[s]; c < f.first_columns[s + 1]; ++c)
            columns[p].push_back(c);
        for (int k = f.first_rows[s]; k < f.first_rows[s + 1]; ++k)
            if (part_of(f.rows[index(k)]) != p)
                reached[p].push_back(f.rows[index(k)]);
    }
    const auto number = [&](std::size_t p, int column) {
        const auto place = [&](const std::vector<int>& sorted) {
            return std::lower_bound(sorted.begin(), sorted.end(), column) - sorted.begin();
        };
        return static_cast<int>(part_of(column) == p ? place(columns[p])
                                                     : std::ssize(columns[p]) + place(reached[p]));
    };
    permutation_.reserve(size);
    for (std::size_t p = parts_.size(); p-- > 0;) {
        std::sort(reached[p].begin(), reached[p].end());
        reached[p].erase(std::unique(reached[p].begin(), reached[p].end()), reached[p].end());
    }
    values_.reserve(index(f.first_values.back()));
    halves_.reserve(index(f.first_values.back()));
    for (std::size_t p = 0; p < parts_.size(); ++p) {
        Part& part = parts_[p];
        part.parent = parts.parent[p];
        if (part.parent != p)
            parts_[part.parent].children.push_back(p);
        part.first_column = permutation_.size();
        part.columns = columns[p].size();
        part.reached = reached[p].size();
        part.place = places_;
        places_ += part.columns + part.reached;
        for (const int c : columns[p])
            permutation_.push_back(f.permutation[index(c)]);
        part.above = reached_rows_.size();
        for (const int row : reached[p])
            reached_rows_.push_back(number(part.parent, row));
        part.first_block = blocks_.size();
        part.first_row = rows_.size();
        part.first_value = values_.size();
        for (const std::size_t s : supernodes[p])
            add_blocks(f, s, [&](int column) { return number(p, column); });
        part.end_block = blocks_.size();
        part.end_row = rows_.size();
        part.end_value = values_.size();
    }
}

/// Appends the columns of a supernode.
/// @param number  That of a row of the factor in its part.
template <class Number>
void SinglePrecisionSolve::add_blocks(const SupernodalFactor& f, std::size_t supernode,
                                      const Number& number)
{
    const int* const row = f.rows.data() + f.first_rows[supernode];
    const Index rows = f.first_rows[supernode + 1] - f.first_rows[supernode];
    const Index columns = f.first_columns[supernode + 1] - f.first_columns[supernode];
    const Eigen::Map<const MatrixXd> factor(f.values + f.first_values[supernode], rows, columns);
    const Index pieces = (columns + widest - 1) / widest;
    const Index piece = (columns + pieces * step - 1) / (pieces * step) * step;
    for (Index first = 0; first < columns; first += piece) {
        const Index width = std::min(piece, columns - first);
        const Index end = first + width;
        MatrixXd inverse = factor.block(first, first, width, width)
                               .triangularView<Eigen::Lower>()
                               .solve(MatrixXd::Identity(width, width));
        MatrixXd below = -factor.block(end, first, rows - end, width) * inverse;
        inverse /= std::sqrt(scale_);
        const Eigen::Array<bool, Eigen::Dynamic, 1> filled = (below.array() != 0.0).rowwise().any();
        Block block{number(row[first]), static_cast<int>(width), 0};
        for (Index r = 0; r < rows - end; ++r)
            if (filled[r]) {
                rows_.push_back(number(row[end + r]));
                ++block.rows;
            }
        const auto append = [&](auto& values, const auto& stored) {
            for (Index r = 0; r < width; ++r)
                for (Index c = 0; c < std::min(width, (r / step + 1) * step); ++c)
                    values.push_back(stored(inverse(r, c)));
            for (Index r = 0; r < rows - end; ++r)
                for (Index c = 0; filled[r] && c < width; ++c)
                    values.push_back(stored(below(r, c)));
        };
        append(values_, [](double value) { return static_cast<float>(value); });
        round_to_halves(inverse);
        round_to_halves(below);
        append(halves_, upper_half);
        blocks_.push_back(block);
    }
}

/// L y = b for the columns of a part.
template <class Entry>
void SinglePrecisionSolve::forward(const Part& part, const Entry* values, const Lanes* rhs,
                                   Lanes* workspace) const
{
    Lanes* const x = workspace + part.place;
    const int* const from = permutation_.data() + part.first_column;
    for (std::size_t i = 0; i < part.columns; ++i)
        x[i] = scale_ * rhs[from[i]];
    std::fill_n(x + part.columns, part.reached, Lanes{});
    for (const std::size_t p : part.children) {
        const Part& child = parts_[p];
        const Lanes* const added = workspace + child.place + child.columns;
        const int* const to = reached_rows_.data() + child.above;
        for (std::size_t i = 0; i < child.reached; ++i)
            x[to[i]] += added[i];
    }
    forward_blocks(blocks_.data() + part.first_block, blocks_.data() + part.end_block,
                   rows_.data() + part.first_row, values + part.first_value, x);
}

/// L^T x = y for the columns of a part.
/// @return Their part of the sum of products.
template <class Entry>
double SinglePrecisionSolve::backward(const Part& part, const Entry* values, const Lanes* rhs,
                                      Lanes* workspace, Lanes* solution) const
{
    Lanes* const x = workspace + part.place;
    const Lanes* const above = workspace + parts_[part.parent].place;
    const int* const from = reached_rows_.data() + part.above;
    for (std::size_t i = 0; i < part.reached; ++i)
        x[part.columns + i] = above[from[i]];
    backward_blocks(blocks_.data() + part.first_block, blocks_.data() + part.end_block,
                    rows_.data() + part.end_row, values + part.end_value, x);
    const int* const to = permutation_.data() + part.first_column;
    double sum = 0.0;
    for (std::size_t begin = 0; begin < part.columns; begin += short_sum) {
        Lanes products{};
        for (std::size_t i = begin; i < std::min(begin + short_sum, part.columns); ++i) {
            solution[to[i]] = x[i];
            products += rhs[to[i]] * x[i];
        }
        sum += lane_sum(products);
    }
    return sum;
}

template <class Entry>
double SinglePrecisionSolve::solve(const Entry* values, const LaneVectors& rhs,
                                   LaneVectors& solution, LaneVectors& workspace) const
{
    if (rhs.cols() != static_cast<Index>(permutation_.size()))
        throw InvalidInput(join("solve: the right-hand side has ", rhs.cols(), " rows, the matrix ",
                                permutation_.size()));
    solution.resize(4, rhs.cols());
    workspace.resize(4, static_cast<Index>(places_));
    const Lanes* const b = lanes(rhs);
    Lanes* const x = lanes(solution);
    Lanes* const work = lanes(workspace);
    std::vector<double> sums(parts_.size());
    const auto for_tier = [&](std::size_t t, const auto& body) {
        const std::size_t first = t == 0 ? 0 : tiers_[t - 1];
        parallel_for(tiers_[t] - first, 1,
                     [&](std::size_t begin, std::size_t) { body(first + begin); });
    };
    for (const std::size_t t : {0, 1, 2})
        for_tier(t, [&](std::size_t p) { forward(parts_[p], values, b, work); });
    for (const std::size_t t : {2, 1, 0})
        for_tier(t, [&](std::size_t p) { sums[p] = backward(parts_[p], values, b, work, x); });
    return std::accumulate(sums.begin(), sums.end(), 0.0);
}

double SinglePrecisionSolve::solve(const LaneVectors& rhs, LaneVectors& solution,
                                   LaneVectors& workspace) const
{
    return solve(values_.data(), rhs, solution, workspace);
}

double SinglePrecisionSolve::precondition(const LaneVectors& rhs, LaneVectors& solution,
                                          LaneVectors& workspace) const
{
    return solve(halves_.data(), rhs, solution, workspace);
}

} // namespace shape
