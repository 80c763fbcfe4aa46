// SPDX-License-Identifier: MIT

#include "libshape/linalg/single_precision_solve.h"

#include "libshape/base/error.h"
#include "libshape/base/format.h"

namespace shape {
namespace {

/// A row of three right-hand sides, the fourth lane idle.
using Lanes = float __attribute__((vector_size(16)));

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

} // namespace

SinglePrecisionSolve::SinglePrecisionSolve(const SparseCholesky& cholesky)
{
    const SupernodalFactor f = cholesky.factor();
    permutation_.assign(f.permutation.begin(), f.permutation.end());
    values_.reserve(static_cast<std::size_t>(f.first_values.back()));
    for (std::size_t s = 0; s + 1 < f.first_columns.size(); ++s) {
        Supernode node{};
        node.first_column = f.first_columns[s];
        node.columns = f.first_columns[s + 1] - node.first_column;
        const int all_rows = f.first_rows[s + 1] - f.first_rows[s];
        node.rows = all_rows - node.columns;
        node.first_row = static_cast<int>(rows_.size());
        const auto below = f.rows.subspan(static_cast<std::size_t>(f.first_rows[s] + node.columns),
                                          static_cast<std::size_t>(node.rows));
        rows_.insert(rows_.end(), below.begin(), below.end());
        const double* const block = f.values + f.first_values[s];
        node.diagonal = values_.size();
        node.below = values_.size() + static_cast<std::size_t>(node.columns * node.columns);
        for (int i = 0; i < all_rows; ++i)
            for (int j = 0; j < node.columns; ++j) {
                const double value = block[i + j * all_rows];
                values_.push_back(static_cast<float>(i < j ? 0.0 : i == j ? 1.0 / value : value));
            }
        supernodes_.push_back(node);
    }
}

Eigen::VectorXd SinglePrecisionSolve::solve(const Eigen::VectorXd& rhs) const
{
    if (rhs.size() != 3 * static_cast<Eigen::Index>(permutation_.size()))
        throw InvalidInput(join("solve: the right-hand side has ", rhs.size(),
                                " entries, the matrix ", permutation_.size(), " rows"));
    std::vector<Lanes> x(permutation_.size());
    for (std::size_t i = 0; i < x.size(); ++i) {
        const double* const from = rhs.data() + 3 * permutation_[i];
        x[i] = Lanes{static_cast<float>(from[0]), static_cast<float>(from[1]),
                     static_cast<float>(from[2]), 0.0F};
    }
    for (const Supernode& node : supernodes_) { // L y = b
        Lanes* const own = x.data() + node.first_column;
        const float* row = values_.data() + node.diagonal;
        for (int i = 0; i < node.columns; ++i, row += node.columns)
            own[i] = (own[i] - combine(row, own, i)) * row[i];
        const int* const below = rows_.data() + node.first_row;
        for (int i = 0; i < node.rows; ++i, row += node.columns)
            x[static_cast<std::size_t>(below[i])] -= combine(row, own, node.columns);
    }
    for (auto node = supernodes_.rbegin(); node != supernodes_.rend(); ++node) { // L^T x = y
        Lanes* const own = x.data() + node->first_column;
        const float* row = values_.data() + node->below;
        const int* const below = rows_.data() + node->first_row;
        for (int i = 0; i < node->rows; ++i, row += node->columns) {
            const Lanes known = x[static_cast<std::size_t>(below[i])];
            for (int j = 0; j < node->columns; ++j)
                own[j] -= row[j] * known;
        }
        for (int i = node->columns; i-- > 0;) {
            row = values_.data() + node->diagonal + i * node->columns;
            own[i] *= row[i];
            for (int j = 0; j < i; ++j)
                own[j] -= row[j] * own[i];
        }
    }
    Eigen::VectorXd solution(rhs.size());
    for (std::size_t i = 0; i < x.size(); ++i)
        for (int k = 0; k < 3; ++k)
            solution[3 * permutation_[i] + k] = static_cast<double>(x[i][k]);
    return solution;
}

} // namespace shape
