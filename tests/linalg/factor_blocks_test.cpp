// SPDX-License-Identifier: MIT

#include "libshape/linalg/factor_blocks.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "libshape/base/random.h"
#include "tests/support/lane_vectors.h"

namespace shape {
using namespace internal;
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

/// A block and the vectors around it: its own, then those that B reaches, in another order.
struct Sample
{
    FactorBlock block;
    MatrixXd inverse; // of L
    MatrixXd below;   // -B L^-1
    std::vector<int> row;

    Sample(int columns, int rows, Random& random) : block{1, columns, rows}
    {
        const auto entry = [&] { return random.uniform(-1.0, 1.0); };
        inverse = MatrixXd::NullaryExpr(columns, columns, entry).triangularView<Eigen::Lower>();
        below = MatrixXd::NullaryExpr(rows, columns, entry);
        for (int r = 0; r < rows; ++r)
            row.push_back(columns + rows - r);
    }

    [[nodiscard]] Index vectors() const { return 1 + block.columns + block.rows; }

    template <class Entry, class Stored>
    [[nodiscard]] std::vector<Entry> values(const Stored& stored) const
    {
        std::vector<Entry> values;
        for (int r = 0; r < block.columns; ++r)
            for (int c = 0; c < stored_row(r, block.columns); ++c)
                values.push_back(stored(inverse(r, c)));
        for (const double entry : below.reshaped<Eigen::RowMajor>())
            values.push_back(stored(entry));
        return values;
    }

    /// What both ways make of vectors, one a row.
    [[nodiscard]] MatrixXd up(MatrixXd x) const
    {
        const MatrixXd own = x.middleRows(1, block.columns);
        x.middleRows(1, block.columns) = inverse * own;
        for (std::size_t r = 0; r < row.size(); ++r)
            x.row(row[r]) += below.row(static_cast<Index>(r)) * own;
        return x;
    }
    [[nodiscard]] MatrixXd down(MatrixXd x) const
    {
        MatrixXd own = inverse.transpose() * x.middleRows(1, block.columns);
        for (std::size_t r = 0; r < row.size(); ++r)
            own += below.row(static_cast<Index>(r)).transpose() * x.row(row[r]);
        x.middleRows(1, block.columns) = own;
        return x;
    }
};

template <class Entry>
void expect_products(const Sample& sample, const std::vector<Entry>& values, Random& random)
{
    const LaneVectors before = test::random_lane_vectors(sample.vectors(), random);
    const MatrixXd x = before.topRows<3>().transpose().cast<double>();
    const FactorBlock* const block = &sample.block;

    LaneVectors up = before;
    forward_substitute(block, block + 1, sample.row.data(), values.data(), lanes(up));
    EXPECT_LT((up.topRows<3>().transpose().cast<double>() - sample.up(x)).norm(), 1e-5);

    LaneVectors down = before;
    back_substitute(block, block + 1, sample.row.data() + sample.row.size(),
                    values.data() + values.size(), lanes(down));
    EXPECT_LT((down.topRows<3>().transpose().cast<double>() - sample.down(x)).norm(), 1e-5);
}

TEST(FactorBlocks, MultiplyBothWays)
{
    Random random(1);
    for (int columns = 1; columns <= widest_block; ++columns)
        for (const int rows : {0, 1, 9}) {
            SCOPED_TRACE(::testing::Message() << columns << " columns, " << rows << " rows");
            Sample sample(columns, rows, random);
            const auto whole = sample.values<float>([](double v) { return static_cast<float>(v); });
            ASSERT_EQ(static_cast<int>(whole.size()), stored_triangle(columns) + rows * columns);
            expect_products(sample, whole, random);

            // Rounded matrices are what their halves are read as.
            round_to_halves(sample.inverse);
            round_to_halves(sample.below);
            expect_products(sample, sample.values<Bfloat16>(upper_half), random);
        }
}

TEST(FactorBlocks, RoundingPassesItsErrorsOn)
{
    Random random(2);
    for (int repeat = 0; repeat < 50; ++repeat) {
        MatrixXd matrix = MatrixXd::NullaryExpr(
            40, 7, [&] { return std::exp(random.uniform(std::log(1e-4), 0.0)); });
        const MatrixXd before = matrix;
        round_to_halves(matrix);
        const Eigen::RowVectorXd errors = matrix.colwise().sum() - before.colwise().sum();
        Index smallest = 0;
        (void)before.rowwise().squaredNorm().minCoeff(&smallest);
        constexpr double half_digit = 1.0 / 256.0;
        EXPECT_LE(errors.cwiseAbs().maxCoeff(), half_digit * matrix.row(smallest).maxCoeff());
        // An entry is off by its own rounding and by what was passed on to it.
        EXPECT_LE((matrix - before).cwiseAbs().maxCoeff(), 2.0 * half_digit);
        EXPECT_NE(matrix, before);
    }
}

TEST(FactorBlocks, RoundingLeavesZerosNextToNothing)
{
    MatrixXd matrix{{0.7, 0.0, 0.0, 0.3}, {0.0, 0.0, 0.0, 0.0}, {0.1, -0.2, 0.3, 0.0}};
    const MatrixXd before = matrix;
    round_to_halves(matrix);
    EXPECT_LT((matrix - before).cwiseAbs().maxCoeff(), 2e-3);
    for (Index i = 0; i < matrix.size(); ++i)
        if (before(i) == 0.0) {
            EXPECT_LT(std::abs(matrix(i)), 1e-11);
            // What is calculated with is not a denormal number.
            EXPECT_TRUE(matrix(i) == 0.0 || std::abs(matrix(i)) > 1e-30);
        }
    EXPECT_LT(matrix(2, 1), 0.0);
}

} // namespace
} // namespace shape
