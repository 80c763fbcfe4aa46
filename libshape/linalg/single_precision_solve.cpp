// SPDX-License-Identifier: MIT

#include "libshape/linalg/single_precision_solve.h"

#include <algorithm>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/threads.h"

namespace shape {
namespace {

/// The sum of weights[j] x[j] over the columns.
inline Lanes combine(const float* weights, const Lanes* x, int columns)
{
    Lanes even{};
    Lanes odd{};
    int j = 0;
    for (; j + 1 < columns; j += 2) {
        even += weights[j] * x[j];
        odd += weights[j + 1] * x[j + 1];
    }
    if (j < columns)
        even += weights[j] * x[j];
    return even + odd;
}

/// Supernodes [first, end) with all their descendants; supernodes are numbered in postorder.
struct Range
{
    int first;
    int end;
};

/// Disjoint subtrees in ascending order, each with at most a sixteenth of the factor's entries.
/// None where the factor is too small to be worth the hand-over.
std::vector<Range> independent_subtrees(const SupernodalFactor& f)
{
    const auto count = static_cast<int>(f.first_columns.size()) - 1;
    const auto entries = [&](int begin, int end) {
        const auto at = [&](int s) { return f.first_values[static_cast<std::size_t>(s)]; };
        return at(end) - at(begin);
    };
    constexpr int worth = 1 << 17;
    std::vector<Range> ranges;
    if (entries(0, count) < worth)
        return ranges;
    const int most = entries(0, count) / 16;

    std::vector<int> supernode_of(f.permutation.size());
    std::vector<int> first_descendant(static_cast<std::size_t>(count));
    for (int s = 0; s < count; ++s) {
        first_descendant[static_cast<std::size_t>(s)] = s;
        for (int c = f.first_columns[static_cast<std::size_t>(s)];
             c < f.first_columns[static_cast<std::size_t>(s) + 1]; ++c)
            supernode_of[static_cast<std::size_t>(c)] = s;
    }
    std::vector<int> parent(static_cast<std::size_t>(count), count);
    for (int s = 0; s < count; ++s) {
        const auto i = static_cast<std::size_t>(s);
        const int columns = f.first_columns[i + 1] - f.first_columns[i];
        if (f.first_rows[i + 1] - f.first_rows[i] == columns)
            continue;
        const int above = f.rows[static_cast<std::size_t>(f.first_rows[i] + columns)];
        parent[i] = supernode_of[static_cast<std::size_t>(above)];
        int& first = first_descendant[static_cast<std::size_t>(parent[i])];
        first = std::min(first, first_descendant[i]);
    }
    for (int s = 0; s < count; ++s) {
        const int first = first_descendant[static_cast<std::size_t>(s)];
        const int above = parent[static_cast<std::size_t>(s)];
        if (entries(first, s + 1) <= most &&
            (above == count ||
             entries(first_descendant[static_cast<std::size_t>(above)], above + 1) > most))
            ranges.push_back({first, s + 1});
    }
    return ranges;
}

} // namespace

SinglePrecisionSolve::SinglePrecisionSolve(const SparseCholesky& cholesky)
{
    const SupernodalFactor f = cholesky.factor();
    permutation_.assign(f.permutation.begin(), f.permutation.end());
    values_.reserve(static_cast<std::size_t>(f.first_values.back()));
    const auto count = static_cast<int>(f.first_columns.size()) - 1;
    const auto first_column = [&](int s) { return f.first_columns[static_cast<std::size_t>(s)]; };

    // What lies between the subtrees is the trunk, whose columns need not follow each other: it is
    // numbered like the whole.
    const auto take = [&](int s, int origin, const auto& number) {
        const auto i = static_cast<std::size_t>(s);
        Supernode node{};
        node.first_column = first_column(s) - origin;
        node.columns = first_column(s + 1) - first_column(s);
        const int all_rows = f.first_rows[i + 1] - f.first_rows[i];
        node.rows = all_rows - node.columns;
        node.first_row = static_cast<int>(rows_.size());
        for (const int row :
             f.rows.subspan(static_cast<std::size_t>(f.first_rows[i] + node.columns),
                            static_cast<std::size_t>(node.rows)))
            rows_.push_back(number(row));
        const double* const block = f.values + f.first_values[i];
        node.diagonal = values_.size();
        node.below = values_.size() + static_cast<std::size_t>(node.columns * node.columns);
        for (int r = 0; r < all_rows; ++r)
            for (int c = 0; c < node.columns; ++c) {
                const double value = block[r + c * all_rows];
                values_.push_back(static_cast<float>(r < c ? 0.0 : r == c ? 1.0 / value : value));
            }
        supernodes_.push_back(node);
    };

    const std::vector<Range> ranges = independent_subtrees(f);
    for (const Range& range : ranges) {
        Subtree subtree;
        subtree.first_column = first_column(range.first);
        subtree.columns = first_column(range.end) - subtree.first_column;
        subtree.first_supernode = supernodes_.size();
        const int end_column = first_column(range.end);
        std::vector<int>& reached = subtree.reached;
        for (int k = f.first_rows[static_cast<std::size_t>(range.first)];
             k < f.first_rows[static_cast<std::size_t>(range.end)]; ++k)
            if (f.rows[static_cast<std::size_t>(k)] >= end_column)
                reached.push_back(f.rows[static_cast<std::size_t>(k)]);
        std::sort(reached.begin(), reached.end());
        reached.erase(std::unique(reached.begin(), reached.end()), reached.end());
        for (int s = range.first; s < range.end; ++s)
            take(s, subtree.first_column, [&](int row) {
                if (row < end_column)
                    return row - subtree.first_column;
                const auto found = std::lower_bound(reached.begin(), reached.end(), row);
                return subtree.columns + static_cast<int>(found - reached.begin());
            });
        subtree.end_supernode = supernodes_.size();
        subtrees_.push_back(std::move(subtree));
    }
    Subtree trunk{0, static_cast<int>(permutation_.size()), supernodes_.size(), 0, {}};
    int s = 0;
    for (const Range& range : ranges) {
        for (; s < range.first; ++s)
            take(s, 0, [](int row) { return row; });
        s = range.end;
    }
    for (; s < count; ++s)
        take(s, 0, [](int row) { return row; });
    trunk.end_supernode = supernodes_.size();
    subtrees_.push_back(std::move(trunk));
}

/// L y = b. Rows that the subtree reaches start at 0 and end as what is to be added to them.
void SinglePrecisionSolve::forward(const Subtree& subtree, Lanes* x) const
{
    for (std::size_t s = subtree.first_supernode; s < subtree.end_supernode; ++s) {
        const Supernode& node = supernodes_[s];
        Lanes* const own = x + node.first_column;
        const float* row = values_.data() + node.diagonal;
        for (int i = 0; i < node.columns; ++i, row += node.columns)
            own[i] = (own[i] - combine(row, own, i)) * row[i];
        const int* const below = rows_.data() + node.first_row;
        for (int i = 0; i < node.rows; ++i, row += node.columns)
            x[below[i]] -= combine(row, own, node.columns);
    }
}

/// L^T x = y.
void SinglePrecisionSolve::backward(const Subtree& subtree, Lanes* x) const
{
    for (std::size_t s = subtree.end_supernode; s-- > subtree.first_supernode;) {
        const Supernode& node = supernodes_[s];
        Lanes* const own = x + node.first_column;
        const float* row = values_.data() + node.below;
        const int* const below = rows_.data() + node.first_row;
        for (int i = 0; i < node.rows; ++i, row += node.columns) {
            const Lanes known = x[below[i]];
            for (int j = 0; j < node.columns; ++j)
                own[j] -= row[j] * known;
        }
        for (int i = node.columns; i-- > 0;) {
            row = values_.data() + node.diagonal + i * node.columns;
            own[i] *= row[i];
            for (int j = 0; j < i; ++j)
                own[j] -= row[j] * own[i];
        }
    }
}

void SinglePrecisionSolve::solve(const LaneVectors& rhs, LaneVectors& solution) const
{
    if (rhs.cols() != static_cast<Eigen::Index>(permutation_.size()))
        throw InvalidInput(join("solve: the right-hand side has ", rhs.cols(), " rows, the matrix ",
                                permutation_.size()));
    solution.resize(4, rhs.cols());
    const Lanes* const from = lanes(rhs);
    Lanes* const to = lanes(solution);
    const Subtree& trunk = subtrees_.back();
    const std::size_t branches = subtrees_.size() - 1;
    std::vector<std::vector<Lanes>> parts(branches);
    const auto gather = [&](int first, int columns, Lanes* x) {
        for (int i = 0; i < columns; ++i)
            x[i] = from[permutation_[static_cast<std::size_t>(first + i)]];
    };
    const auto scatter = [&](int first, int columns, const Lanes* x) {
        for (int i = 0; i < columns; ++i)
            to[permutation_[static_cast<std::size_t>(first + i)]] = x[i];
    };
    std::vector<Lanes> x(permutation_.size());
    parallel_for(branches, 1, [&](std::size_t k, std::size_t) {
        const Subtree& subtree = subtrees_[k];
        parts[k].resize(static_cast<std::size_t>(subtree.columns) + subtree.reached.size());
        gather(subtree.first_column, subtree.columns, parts[k].data());
        forward(subtree, parts[k].data());
    });
    gather(0, trunk.columns, x.data());
    for (std::size_t k = 0; k < branches; ++k)
        for (std::size_t i = 0; i < subtrees_[k].reached.size(); ++i)
            x[static_cast<std::size_t>(subtrees_[k].reached[i])] +=
                parts[k][static_cast<std::size_t>(subtrees_[k].columns) + i];
    forward(trunk, x.data());
    backward(trunk, x.data());
    scatter(0, trunk.columns, x.data());
    parallel_for(branches, 1, [&](std::size_t k, std::size_t) {
        const Subtree& subtree = subtrees_[k];
        for (std::size_t i = 0; i < subtree.reached.size(); ++i)
            parts[k][static_cast<std::size_t>(subtree.columns) + i] =
                x[static_cast<std::size_t>(subtree.reached[i])];
        backward(subtree, parts[k].data());
        scatter(subtree.first_column, subtree.columns, parts[k].data());
    });
}

} // namespace shape
