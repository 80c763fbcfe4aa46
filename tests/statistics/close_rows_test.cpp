// SPDX-License-Identifier: MIT

#include "libshape/statistics/close_rows.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "libshape/base/error.h"
#include "libshape/statistics/inner_products.h"
#include "tests/support/matrices.h"

namespace shape {
using namespace internal;
namespace {

using test::random_matrix;

/// Rows that repeat `things` things in turn, each with `noise` of its own.
Eigen::MatrixXd repeated(int things, int rows, double noise, unsigned seed)
{
    const Eigen::MatrixXd all = random_matrix(things, 30, seed);
    Eigen::MatrixXd data = noise * random_matrix(rows, 30, seed + 1);
    for (int i = 0; i < rows; ++i)
        data.row(i) += all.row(i % things);
    return data;
}

Grouping in_turn(int things, int rows)
{
    std::vector<std::string> values;
    for (int i = 0; i < rows; ++i)
        values.push_back(std::to_string(i % things));
    return group_by(values);
}

TEST(CloseRows, ClosenessIsTheRatioOfRootMeanSquareDistances)
{
    RowMatrix line(6, 1);
    line << 0, 1, 10, 12, 100, 104;
    const Eigen::MatrixXd products = centred_inner_products(line);
    const Grouping blocks = group_by({"a", "a", "b", "b", "c", "c"});
    const double within = (1.0 + 4.0 + 16.0) / 3.0;
    double between = 0.0;
    for (const int a : {0, 1})
        for (const int b : {2, 3}) {
            between += std::pow(line(a, 0) - line(b, 0), 2);
            for (const int c : {4, 5})
                between +=
                    (std::pow(line(a, 0) - line(c, 0), 2) + std::pow(line(b, 0) - line(c, 0), 2)) /
                    2.0; // each pair is met twice
        }
    EXPECT_NEAR(closeness(products, blocks, one_group(6)), std::sqrt(within / (between / 12.0)),
                1e-9);
    // Pairs of a or b and c do not count.
    const Grouping strata = group_by({"x", "x", "x", "x", "y", "y"});
    const double near = (100.0 + 144.0 + 81.0 + 121.0) / 4.0;
    EXPECT_NEAR(closeness(products, blocks, strata), std::sqrt(within / near), 1e-9);
    const double infinity = std::numeric_limits<double>::infinity();
    EXPECT_EQ(closeness(products, blocks, blocks), infinity);
    EXPECT_EQ(closeness(products, groups_of_one(6), one_group(6)), infinity);
    EXPECT_EQ(closeness(Eigen::MatrixXd::Zero(6, 6), blocks, one_group(6)), infinity);
    EXPECT_THROW((void)closeness(products, one_group(5), one_group(6)), InvalidInput);
}

TEST(CloseRows, ClosenessIsAboutOneWhereBlocksMeanNothing)
{
    for (unsigned seed = 0; seed < 20; ++seed) {
        const Eigen::MatrixXd products = inner_products(random_matrix(12, 30, seed));
        EXPECT_NEAR(closeness(products, in_turn(3, 12), one_group(12)), 1.0, 0.2);
    }
}

TEST(CloseRows, RepeatedRowsFallIntoSets)
{
    for (const int things : {3, 4, 7})
        for (const double noise : {0.0, 1e-9, 0.01, 0.1}) {
            const Eigen::MatrixXd data = repeated(things, 2 * things + 1, noise, 5);
            const std::optional<Grouping> sets = single_linkage_sets(inner_products(data));
            ASSERT_TRUE(sets) << things << " " << noise;
            EXPECT_EQ(sets->group_of, in_turn(things, 2 * things + 1).group_of);
            // About any point, and in any unit.
            const auto again = single_linkage_sets(centred_inner_products(RowMatrix(1e-3 * data)));
            ASSERT_TRUE(again);
            EXPECT_EQ(again->group_of, sets->group_of);
        }
}

TEST(CloseRows, OthersDoNot)
{
    for (unsigned seed = 0; seed < 50; ++seed)
        for (const int rows : {6, 12, 40})
            for (const int width : {5, 30}) // of few dimensions, distances vary more
                EXPECT_FALSE(single_linkage_sets(inner_products(random_matrix(rows, width, seed))))
                    << seed << " " << rows << " " << width;
    // Two sets are two kinds; single rows are no repetitions; noise as large as the differences.
    EXPECT_FALSE(single_linkage_sets(inner_products(repeated(2, 12, 0.01, 1))));
    EXPECT_FALSE(single_linkage_sets(inner_products(repeated(7, 12, 0.01, 1))));
    EXPECT_FALSE(single_linkage_sets(inner_products(repeated(3, 12, 0.7, 1))));
    EXPECT_FALSE(single_linkage_sets(inner_products(repeated(2, 5, 0.01, 1))));
    EXPECT_FALSE(single_linkage_sets(Eigen::MatrixXd::Zero(8, 8)));
    // A steady walk.
    Eigen::MatrixXd walk(12, 1);
    for (int i = 0; i < 12; ++i)
        walk(i, 0) = i + 0.3 * (i % 3);
    EXPECT_FALSE(single_linkage_sets(inner_products(walk)));
}

} // namespace
} // namespace shape
