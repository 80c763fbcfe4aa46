// SPDX-License-Identifier: MIT

#include "libshape/linalg/single_precision_solve.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/threads.h"
#include "libshape/base/to_size.h"

namespace shape::internal {
namespace {

// X = A^-1 B for three columns by the factor of a SparseCholesky, in float. With the elimination tree cut into
// parts, leaf subtrees below middle ones below the root,
//
//          [ root ]             forward: L y = b, leaves first; every part adds what it does to
//         /        \             the rows of the part above to a copy of them of its own,
//     [middle]   [middle]
//      /  \        /  \          backward: L^T x = y, the root first; every part reads those rows.
//    [l]  [l]   [l]  [l]
//
// In memory every part has its place in the workspace, which no other part writes to, so that parts of a
// tier may be worked on at once with the same bits:
//
//     workspace   | columns of part 0 | rows reached above | columns of part 1 | rows reached above | ...
//     values_     | blocks of part 0 (factor_blocks.cpp)   | blocks of part 1  | ...
//
// CHOLMOD's solve takes double precision, one thread and, for three right-hand sides, gathers and scatters
// around calls of BLAS that are too small for it.

using Eigen::Index;
using Eigen::MatrixXd;

/// Parts of the elimination tree, the lower tiers first: each a subtree less the parts below.
struct Cut
{
    std::vector<std::size_t> part_of_column; ///< The part that each column of the factor is in.
    std::vector<std::size_t> parent;         ///< The part above each part; itself at a root.
    std::array<std::size_t, 3> tiers{};      ///< Where the leaf, middle and root subtrees end.
};

/// Leaf subtrees are the largest with at most a sixteenth of the factor's entries, middle ones those
/// with at most 6/10; the rest is the root. All is root where the factor is too small to be worth the hand-over.
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
        above[s] = next == f.first_rows[s + 1] ? s : supernode_of[to_size(f.rows[to_size(next)])];
        entries[s] += f.first_values[s + 1] - f.first_values[s];
        if (above[s] != s)
            entries[above[s]] += entries[s];
    }
    const double all = f.first_values.back();
    // Entries of 2 bytes, read both ways: below an eighth of a megabyte a solve takes some 10 microseconds, and
    // handing parts to threads (1 microsecond a tier) is no longer small beside it.
    constexpr double worth = 1 << 15;
    // Sixteen leaves keep up to eight threads busy though they are unequal; smaller ones would copy more rows
    // than they save.
    constexpr double largest_leaf = 1.0 / 16.0;
    // What is above this share is the chain of the largest separators, each over the one below, which no two
    // threads can work on side by side.
    constexpr double largest_middle = 0.6;
    const auto tier = [&](std::size_t s) -> std::size_t {
        return all < worth                          ? 2
               : entries[s] <= largest_leaf * all   ? 0
               : entries[s] <= largest_middle * all ? 1
                                                    : 2;
    };

    Cut cut;
    std::vector<std::size_t> part(count);
    std::vector<std::size_t> tops; // of the parts
    for (std::size_t t = 0; t < 2; ++t) {
        for (std::size_t s = 0; s < count; ++s)
            if (tier(s) == t && (above[s] == s || tier(above[s]) != t)) {
                part[s] = tops.size();
                tops.push_back(s);
            }
        cut.tiers[t] = tops.size();
    }
    const std::size_t root = tops.size();
    cut.tiers[2] = root + 1;
    for (std::size_t s = count; s-- > 0;)
        if (tier(s) == 2)
            part[s] = root;
        else if (above[s] != s && tier(above[s]) == tier(s))
            part[s] = part[above[s]];
    for (const std::size_t top : tops)
        cut.parent.push_back(part[above[top]]);
    cut.parent.push_back(root);
    for (const std::size_t s : supernode_of)
        cut.part_of_column.push_back(part[s]);
    return cut;
}

} // namespace

SinglePrecisionSolve::SinglePrecisionSolve(const SparseCholesky& cholesky)
{
    const SupernodalFactor f = cholesky.factor();
    // Entries of inverses of about 1, by a power of two: the same bits in any unit that is one.
    scale_ = std::ldexp(1.0F, -2 * std::ilogb(f.values[0]));
    const Cut parts = cut(f);
    const auto part_of = [&](int column) { return parts.part_of_column[to_size(column)]; };
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
            if (part_of(f.rows[to_size(k)]) != p)
                reached[p].push_back(f.rows[to_size(k)]);
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
    values_.reserve(to_size(f.first_values.back()));
    halves_.reserve(to_size(f.first_values.back()));
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
            permutation_.push_back(f.permutation[to_size(c)]);
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

SinglePrecisionSolve::SinglePrecisionSolve(ByteReader& from)
    : permutation_(from.array<int>()),
      blocks_(from.array<FactorBlock>()),
      rows_(from.array<int>()),
      reached_rows_(from.array<int>()),
      values_(from.array<float>()),
      halves_(from.array<Bfloat16>())
{
    for (std::size_t& end : tiers_)
        end = from.number<std::uint32_t>();
    scale_ = from.number<float>();
    const auto numbers = from.array<std::uint32_t>();
    auto next = numbers.begin();
    parts_.resize(numbers.size() / Part().numbers().size());
    for (Part& part : parts_)
        for (std::size_t* const number : part.numbers())
            *number = *next++;
    for (std::size_t p = 0; p < parts_.size(); ++p) {
        const Part& part = parts_[p];
        if (part.parent >= parts_.size())
            throw InvalidInput("factor: a part hangs from none that there is");
        if (part.parent != p)
            parts_[part.parent].children.push_back(p);
        places_ = std::max(places_, part.place + part.columns + part.reached);
    }
    check();
}

void SinglePrecisionSolve::write(ByteWriter& to) const
{
    to.array(permutation_);
    to.array(blocks_);
    to.array(rows_);
    to.array(reached_rows_);
    to.array(values_);
    to.array(halves_);
    for (const std::size_t end : tiers_)
        to.number(static_cast<std::uint32_t>(end));
    to.number(scale_);
    std::vector<std::uint32_t> numbers;
    for (Part part : parts_)
        for (const std::size_t* const number : part.numbers())
            numbers.push_back(static_cast<std::uint32_t>(*number));
    to.array(numbers);
}

/// That no solve reads or writes where nothing is.
void SinglePrecisionSolve::check() const
{
    const auto require = [](bool holds) {
        if (!holds)
            throw InvalidInput("factor: its numbers do not fit each other");
    };
    const std::size_t size = permutation_.size();
    require(!parts_.empty() && tiers_[0] <= tiers_[1] && tiers_[1] <= tiers_[2] &&
            tiers_[2] == parts_.size() && halves_.size() == values_.size());
    for (const int row : permutation_)
        require(row >= 0 && to_size(row) < size);
    for (std::size_t p = 0; p < parts_.size(); ++p) {
        const Part& part = parts_[p];
        const Part& above = parts_[part.parent];
        const std::size_t vectors = part.columns + part.reached;
        require(part.first_column + part.columns <= size &&
                part.above + part.reached <= reached_rows_.size() &&
                part.first_block <= part.end_block && part.end_block <= blocks_.size() &&
                part.first_row <= part.end_row && part.end_row <= rows_.size() &&
                part.first_value <= part.end_value && part.end_value <= values_.size());
        for (std::size_t i = part.above; i < part.above + part.reached; ++i)
            require(reached_rows_[i] >= 0 &&
                    to_size(reached_rows_[i]) < above.columns + above.reached);
        for (std::size_t i = part.first_row; i < part.end_row; ++i)
            require(rows_[i] >= 0 && to_size(rows_[i]) < vectors);
        std::size_t rows = 0;
        std::size_t values = 0;
        for (std::size_t b = part.first_block; b < part.end_block; ++b) {
            const FactorBlock& block = blocks_[b];
            require(block.columns > 0 && block.columns <= widest_block && block.rows >= 0 &&
                    block.first_column >= 0 &&
                    to_size(block.first_column + block.columns) <= vectors);
            rows += to_size(block.rows);
            values += to_size(stored_triangle(block.columns) + block.columns * block.rows);
        }
        require(rows == part.end_row - part.first_row &&
                values == part.end_value - part.first_value);
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
    const Index pieces = (columns + widest_block - 1) / widest_block;
    const Index piece =
        (columns + pieces * triangle_step - 1) / (pieces * triangle_step) * triangle_step;
    for (Index first = 0; first < columns; first += piece) {
        const Index width = std::min(piece, columns - first);
        const Index end = first + width;
        MatrixXd inverse = factor.block(first, first, width, width)
                               .triangularView<Eigen::Lower>()
                               .solve(MatrixXd::Identity(width, width));
        MatrixXd below = -factor.block(end, first, rows - end, width) * inverse;
        inverse /= std::sqrt(scale_);
        const Eigen::Array<bool, Eigen::Dynamic, 1> filled = (below.array() != 0.0).rowwise().any();
        FactorBlock block{number(row[first]), static_cast<int>(width), 0};
        for (Index r = 0; r < rows - end; ++r)
            if (filled[r]) {
                rows_.push_back(number(row[end + r]));
                ++block.rows;
            }
        const auto append = [&](auto& values, const auto& stored) {
            for (Index r = 0; r < width; ++r)
                for (Index c = 0; c < stored_row(static_cast<int>(r), static_cast<int>(width)); ++c)
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
    forward_substitute(blocks_.data() + part.first_block, blocks_.data() + part.end_block,
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
    back_substitute(blocks_.data() + part.first_block, blocks_.data() + part.end_block,
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
    for (std::size_t t = 0; t < 3; ++t)
        for_tier(t, [&](std::size_t p) { forward(parts_[p], values, b, work); });
    for (std::size_t t = 3; t-- > 0;)
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

} // namespace shape::internal
