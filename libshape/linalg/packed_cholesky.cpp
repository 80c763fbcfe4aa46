// SPDX-License-Identifier: MIT

#include "libshape/linalg/packed_cholesky.h"

#include <algorithm>

#include "libshape/base/error.h"
#include "libshape/base/format.h"

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

std::size_t at(int i)
{
    return static_cast<std::size_t>(i);
}

/// The entries of a lower triangle, row by row.
struct Rows
{
    std::vector<int> begins; // size + 1
    std::vector<int> columns;
    std::vector<double> values;

    Rows(int size, std::span<const SymmetricEntry> entries)
        : begins(at(size) + 1, 0), columns(entries.size()), values(entries.size())
    {
        for (const SymmetricEntry& entry : entries)
            ++begins[at(entry.row) + 1];
        for (std::size_t i = 1; i < begins.size(); ++i)
            begins[i] += begins[i - 1];
        std::vector<int> cursor(begins.begin(), begins.end() - 1);
        for (const SymmetricEntry& entry : entries) {
            const std::size_t place = at(cursor[at(entry.row)]++);
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
    std::vector<int> parent(at(size), -1), visited(at(size), -1), ends(at(size), 0);
    for (int k = 0; k < size; ++k) {
        visited[at(k)] = k;
        for (int p = a.begins[at(k)]; p < a.begins[at(k) + 1]; ++p)
            for (int i = a.columns[at(p)]; visited[at(i)] != k; i = parent[at(i)]) {
                if (parent[at(i)] < 0)
                    parent[at(i)] = k;
                ++ends[at(i)];
                visited[at(i)] = k;
            }
    }
    int total = 0;
    for (int& end : ends) {
        const int count = end;
        end = total; // the column's begin: filled one by one below, it becomes its end
        total += count;
    }
    rows_.resize(factor.entries + at(total));
    values_.resize(rows_.size());
    inverse_pivots_.resize(factor.columns + at(size));
    int* rows = rows_.data() + factor.entries;
    double* values = values_.data() + factor.entries;
    double* inverse_pivots = inverse_pivots_.data() + factor.columns;

    // Each row in turn is the solution of a triangular system with the rows before it.
    const std::vector<int> begins = ends;
    std::vector<double> row(at(size), 0.0);
    std::vector<int> pattern(at(size)), path(at(size));
    std::fill(visited.begin(), visited.end(), -1);
    for (int k = 0; k < size; ++k) {
        visited[at(k)] = k;
        int top = size; // the pattern in topological order is [top, size)
        for (int p = a.begins[at(k)]; p < a.begins[at(k) + 1]; ++p) {
            row[at(a.columns[at(p)])] = a.values[at(p)];
            int length = 0;
            for (int i = a.columns[at(p)]; visited[at(i)] != k; i = parent[at(i)]) {
                path[at(length++)] = i;
                visited[at(i)] = k;
            }
            while (length > 0)
                pattern[at(--top)] = path[at(--length)];
        }
        double pivot = diagonal[k];
        for (; top < size; ++top) {
            const std::size_t i = at(pattern[at(top)]);
            const double value = row[i];
            row[i] = 0.0;
            for (int q = begins[i]; q < ends[i]; ++q)
                row[at(rows[q])] -= values[q] * value;
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
