// SPDX-License-Identifier: MIT

#include "libshape/linalg/block_products.h"

#include <gtest/gtest.h>

#include <tuple>

#include "tests/support/matrices.h"

namespace shape {
using namespace internal;
using Eigen::Index;
namespace {

/// Of what is added up: a sum of `depth` products of numbers up to some 3 is off by less.
double rounding(Index depth)
{
    return 1e-15 * static_cast<double>(depth + 8);
}

/// Rows, columns, and terms of a sum; few, at the rims of kernels, and beyond few_rows.
class BlockProducts : public testing::TestWithParam<std::tuple<int, int, int>>
{
};

TEST_P(BlockProducts, AreThoseOfEigen)
{
    const auto [rows, columns, depth] = GetParam();
    const RowMatrix start = test::random_matrix(rows, columns, 1);
    const RowMatrix a = test::random_matrix(depth, rows, 2);
    const RowMatrix b = test::random_matrix(depth, columns, 3);
    const RowMatrix a_rows = a.transpose();
    const RowMatrix b_rows = b.transpose();
    const RowMatrix wanted = start + a.transpose() * b;

    RowMatrix of_columns = start;
    add_product_of_columns(a, b, of_columns);
    EXPECT_LT((of_columns - wanted).cwiseAbs().maxCoeff(), rounding(depth));

    RowMatrix with_rows = start;
    add_product_with_rows(a_rows, b_rows, with_rows);
    EXPECT_LT((with_rows - wanted).cwiseAbs().maxCoeff(), rounding(depth));

    RowMatrix plain = start;
    add_product(a_rows, b, plain);
    EXPECT_LT((plain - wanted).cwiseAbs().maxCoeff(), rounding(depth));
}

INSTANTIATE_TEST_SUITE_P(Sizes, BlockProducts,
                         testing::Combine(testing::Values(1, 3, 4, 9, 24, 30),
                                          testing::Values(1, 4, 11, 12, 193, 600),
                                          testing::Values(1, 5, 24, 25, 70)));

TEST(ProductsOfBlocks, OfColumnsHaveTheSameBitsHoweverRowsAndColumnsAreCut)
{
    const RowMatrix a = test::random_matrix(61, 21, 4);
    const RowMatrix b = test::random_matrix(61, 1003, 5);
    RowMatrix whole = RowMatrix::Zero(21, 1003);
    add_product_of_columns(a, b, whole);
    for (const Index tile : {1, 4, 7, 40})
        for (const Index width : {5, 192, 504}) {
            RowMatrix cut = RowMatrix::Zero(21, 1003);
            for (Index row = 0; row < 61; row += tile)
                for (Index column = 0; column < 1003; column += width) {
                    const Index rows = std::min(tile, 61 - row);
                    const Index columns = std::min(width, 1003 - column);
                    add_product_of_columns(a.middleRows(row, rows),
                                           b.block(row, column, rows, columns),
                                           cut.middleCols(column, columns));
                }
            EXPECT_EQ(cut, whole);
        }
}

TEST(ProductsOfBlocks, OfNothingAddNothing)
{
    RowMatrix sum = RowMatrix::Ones(3, 5);
    add_product_of_columns(RowMatrix(0, 3), RowMatrix(0, 5), sum);
    add_product_with_rows(RowMatrix(3, 0), RowMatrix(5, 0), sum);
    add_product(RowMatrix(3, 0), RowMatrix(0, 5), sum);
    EXPECT_EQ(sum, RowMatrix::Ones(3, 5));
}

} // namespace
} // namespace shape
