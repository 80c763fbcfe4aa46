// SPDX-License-Identifier: MIT

#include "libshape/linalg/added_rows.h"

#include <gtest/gtest.h>

#include "tests/support/matrices.h"

namespace shape {
using namespace internal;
namespace {

TEST(AddedRows, AreAddedInTheirOrderForEveryEntry)
{
    const RowMatrix rows = test::random_matrix(5, 3000, 1); // several pieces
    const Eigen::VectorXd base = test::random_matrix(3000, 1, 2);
    const Eigen::VectorXd weights{{0.3, -1.7, 0.0, 1e-3}}; // fewer than rows
    Eigen::VectorXd wanted = base;
    for (int i = 0; i < wanted.size(); ++i)
        for (int k = 0; k < weights.size(); ++k)
            wanted[i] += weights[k] * rows(k, i);
    EXPECT_EQ(with_rows_added(base, rows, weights), wanted);
}

TEST(AddedRows, LeavesTheBaseWhereThereIsNothingToAdd)
{
    const Eigen::VectorXd base = test::random_matrix(7, 1, 3);
    EXPECT_EQ(with_rows_added(base, RowMatrix::Ones(2, 7), {}), base);
    EXPECT_EQ(with_rows_added({}, RowMatrix(2, 0), Eigen::VectorXd::Ones(2)).size(), 0);
}

} // namespace
} // namespace shape
