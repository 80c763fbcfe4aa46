// SPDX-License-Identifier: MIT

#include "libshape/linalg/packed_cholesky.h"

#include <algorithm>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/to_size.h"

namespace shape::internal {
namespace {

// L D L^T = A row by row ("up-looking"): row k of L solves L(0..k-1) y = a_k, and d_k = a_kk - sum y_i^2 / d_i.
// In memory the factors of thousands of matrices follow one another, each by columns:
//
//     values_           | L_0: column 0, column 1, ..  | L_1: column 0, ..  | ...
//     rows_             | its rows, the same places    |
//     column_ends_      | e0 e1 ..                     | e0 ..              |  from the factor's first entry on
//     inverse_pivots_   | 1/d0 1/d1 ..                 | 1/d0 ..            |
//
// so that solves one after the other read memory from start to end, as a pose does. It is not a library's
// factor a matrix: most have a few dozen unknowns, and what CHOLMOD or Eigen allocate and check for each would
// cost more than the solve. solve() works on four right-hand sides, a point and 1, in one
// register of AVX (Eigen::Vector4d).

/// The entries of a lower triangle, row by row.
struct Rows
{
    std::vector<int> begins; // size + 1
    std::vector<int> columns;
    std::vector<double> values;

    Rows(int size, std::span<const SymmetricEntry> entries)
        : begins(to_size(size) + 1, 0), columns(entries.size()), values(entries.size())
    {
        for (const SymmetricEntry& entry : entries)
            ++begins[to_size(entry.row) + 1];
        for (std::size_t i = 1; i < begins.size(); ++i)
            begins[i] += begins[i - 1];
        std::vector<int> cursor(begins.begin(), begins.end() - 1);
        for (const SymmetricEntry& entry : entries) {
            const std::size_t place = to_size(cursor[to_size(entry.row)]++);
            columns[place] = entry.column;
            values[place] = entry.value;
        }
    }
};

} // namespace

std::size_t PackedCholesky::add(const Eigen::VectorXd& diagonal,
                                std::span<const SymmetricEntry> entries)
{
    const int size = static_cast<int>(diagonal.size());
    const Rows a(size, entries);
    const Factor factor{size, column_ends_.size(), rows_.size()};

    // Row k of L has entries at all nodes of the elimination tree that lie between a column of
    // row k of A and k. One walk finds the tree and the length of every column.
    std::vector<int> parent(to_size(size), -1), visited(to_size(size), -1), ends(to_size(size), 0);
    for (int k = 0; k < size; ++k) {
        visited[to_size(k)] = k;
        for (int p = a.begins[to_size(k)]; p < a.begins[to_size(k) + 1]; ++p)
            for (int i = a.columns[to_size(p)]; visited[to_size(i)] != k; i = parent[to_size(i)]) {
                if (parent[to_size(i)] < 0)
                    parent[to_size(i)] = k;
                ++ends[to_size(i)];
                visited[to_size(i)] = k;
            }
    }
    int total = 0;
    for (int& end : ends) {
        const int count = end;
        end = total; // the column's begin: filled one by one below, it becomes its end
        total += count;
    }
    rows_.resize(factor.entries + to_size(total));
    values_.resize(rows_.size());
    inverse_pivots_.resize(factor.columns + to_size(size));
    int* rows = rows_.data() + factor.entries;
    double* values = values_.data() + factor.entries;
    double* inverse_pivots = inverse_pivots_.data() + factor.columns;

    // Each row in turn is the solution of a triangular system with the rows before it.
    const std::vector<int> begins = ends;
    std::vector<double> row(to_size(size), 0.0);
    std::vector<int> pattern(to_size(size)), path(to_size(size));
    std::fill(visited.begin(), visited.end(), -1);
    for (int k = 0; k < size; ++k) {
        visited[to_size(k)] = k;
        int top = size; // the pattern in topological order is [top, size)
        for (int p = a.begins[to_size(k)]; p < a.begins[to_size(k) + 1]; ++p) {
            row[to_size(a.columns[to_size(p)])] = a.values[to_size(p)];
            int length = 0;
            for (int i = a.columns[to_size(p)]; visited[to_size(i)] != k; i = parent[to_size(i)]) {
                path[to_size(length++)] = i;
                visited[to_size(i)] = k;
            }
            while (length > 0)
                pattern[to_size(--top)] = path[to_size(--length)];
        }
        double pivot = diagonal[k];
        for (; top < size; ++top) {
            const std::size_t i = to_size(pattern[to_size(top)]);
            const double value = row[i];
            row[i] = 0.0;
            for (int q = begins[i]; q < ends[i]; ++q)
                row[to_size(rows[q])] -= values[q] * value;
            const double scaled = value * inverse_pivots[i];
            pivot -= scaled * value;
            rows[ends[i]] = k;
            values[ends[i]++] = scaled;
        }
        if (!(pivot > 0.0))
            throw NumericalError(join("Cholesky factorisation of a matrix of size ", size,
                                      ": pivot ", k, " is ", pivot, ", must be > 0"));
        inverse_pivots[k] = 1.0 / pivot;
    }
    column_ends_.insert(column_ends_.end(), ends.begin(), ends.end());
    factors_.push_back(factor);
    return factors_.size() - 1;
}

void PackedCholesky::solve(std::size_t index, Eigen::Vector4d* x) const
{
    const Factor& factor = factors_[index];
    const int* rows = rows_.data() + factor.entries;
    const double* values = values_.data() + factor.entries;
    const int* ends = column_ends_.data() + factor.columns;
    const double* inverse_pivots = inverse_pivots_.data() + factor.columns;
    int p = 0;
    for (int j = 0; j < factor.size; ++j) {
        const Eigen::Vector4d known = x[j];
        for (; p < ends[j]; ++p)
            x[rows[p]] -= values[p] * known;
        x[j] = known * inverse_pivots[j];
    }
    for (int j = factor.size - 1; j >= 0; --j) {
        Eigen::Vector4d sum = x[j];
        const int begin = j == 0 ? 0 : ends[j - 1];
        for (p = begin; p < ends[j]; ++p)
            sum -= values[p] * x[rows[p]];
        x[j] = sum;
    }
}

} // namespace shape::internal
