// SPDX-License-Identifier: MIT

#include "libshape/statistics/tiled_gram.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "libshape/statistics/column_strips.h"
#include "libshape/statistics/inner_products.h"
#include "tests/support/files.h"
#include "tests/support/matrices.h"
#include "tests/support/thread_scope.h"

namespace shape {
using namespace internal;
namespace {

using Eigen::Index;

/// Runs all passes; between them the state goes out and in again if wanted.
TiledGram gram_of(const RowMatrix& data, Index held, bool resume = false)
{
    TiledGram gram(data.rows(), data.cols(), held);
    int passes = 0;
    while (!gram.is_complete()) {
        for (Index first = gram.begin(); first < data.rows(); first += gram.tile()) {
            RowMatrix tile = data.middleRows(first, std::min(gram.tile(), data.rows() - first));
            gram.add(first, tile);
        }
        gram.end_pass();
        ++passes;
        if (resume) {
            PassState state;
            gram.release(state);
            TiledGram next(data.rows(), data.cols(), held);
            PassStateReader reader(std::move(state));
            next.restore(reader);
            gram = std::move(next);
        }
    }
    EXPECT_EQ(passes, gram.pass_count());
    return gram;
}

RowMatrix sample()
{
    // A mean that is large beside the deviations, and a last tile that is not full.
    return test::random_matrix(300, 700, 1).array() * 1e-3 + 5.0;
}

TEST(TiledGram, IsTheMatrixOfCentredInnerProducts)
{
    const RowMatrix data = sample();
    const TiledGram gram = gram_of(data, 300);
    const Eigen::MatrixXd expected = centred_inner_products(data);
    EXPECT_LE((gram.products() - expected).cwiseAbs().maxCoeff(),
              1e-12 * expected.diagonal().maxCoeff());
    EXPECT_TRUE(gram.products() == gram.products().transpose());
    EXPECT_LE((gram.mean().transpose() - data.colwise().mean()).cwiseAbs().maxCoeff(), 1e-14);
}

TEST(TiledGram, HasTheSameBitsWhateverIsHeldForAnyThreadCountAndAfterEveryBreak)
{
    const RowMatrix data = sample();
    const Eigen::MatrixXd products = gram_of(data, 300).products();
    for (const Index held : {0, 128, 256}) {
        EXPECT_TRUE(gram_of(data, held).products() == products) << held;
        EXPECT_TRUE(gram_of(data, held, true).products() == products) << held;
    }
    for (const int threads : {1, 3}) {
        const test::ThreadScope scope(threads);
        EXPECT_TRUE(gram_of(data, 128).products() == products) << threads;
    }
}

TEST(TiledGram, HasTheSameBitsWhereColumnsComeInsteadOfRows)
{
    // Three strips, the last one of 104 columns; tiles of 128 and, of few long rows, of 4.
    const RowMatrix data = test::random_matrix(300, 4200, 2).array() + 3.0;
    for (const RowMatrix& rows : {data, RowMatrix(data.topRows(23).replicate(1, 40))}) {
        const TiledGram expected = gram_of(rows, 5);
        const test::TemporaryDirectory folder;
        const auto strips = ColumnStrips::make(folder.path(), rows.rows(), rows.cols());
        ASSERT_TRUE(strips);
        for (Index first = 0; first < rows.rows(); first += 7)
            strips->put(first, rows.middleRows(first, std::min<Index>(7, rows.rows() - first)));
        TiledGram gram(rows.rows(), rows.cols(), 0);
        gram.start_at(
            rows.topRows(std::min(gram.tile(), rows.rows())).colwise().mean().transpose());
        strips->for_each(
            [&](Index first, RowMatrix& columns) { gram.add_columns(first, columns); });
        gram.end_columns();
        EXPECT_TRUE(gram.is_complete());
        EXPECT_TRUE(gram.products() == expected.products());
        EXPECT_TRUE(gram.mean() == expected.mean());
    }
}

TEST(ColumnStrips, GoInStripsAsTheyCameInRows)
{
    const RowMatrix data = test::random_matrix(5, 5000, 3);
    const test::TemporaryDirectory folder;
    const auto strips = ColumnStrips::make(folder.path(), 5, 5000);
    ASSERT_TRUE(strips);
    strips->put(2, data.bottomRows(3));
    strips->put(0, data.topRows(2));
    for (int time = 0; time < 2; ++time) {
        RowMatrix found = RowMatrix::Zero(5, 5000);
        Index next = 0;
        strips->for_each([&](Index first, RowMatrix& columns) {
            EXPECT_EQ(first, next);
            next += columns.cols();
            found.middleCols(first, columns.cols()) = columns;
            columns.setZero(); // changes nothing on disc
        });
        EXPECT_TRUE(found == data);
    }
    EXPECT_FALSE(ColumnStrips::make(folder / "missing", 5, 5000));
}

TEST(TiledGram, TilesAreSmallWhereRowsAreLong)
{
    EXPECT_EQ(TiledGram::tile_rows(1), 128);
    EXPECT_EQ(TiledGram::tile_rows(173000), 8);
    EXPECT_EQ(TiledGram::tile_rows(100000000), 4);
}

} // namespace
} // namespace shape
