// SPDX-License-Identifier: MIT

#include "libshape/statistics/tiled_gram.h"

#include <gtest/gtest.h>

#include "libshape/statistics/inner_products.h"
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

TEST(TiledGram, TilesAreSmallWhereRowsAreLong)
{
    EXPECT_EQ(TiledGram::tile_rows(1), 128);
    EXPECT_EQ(TiledGram::tile_rows(173000), 8);
    EXPECT_EQ(TiledGram::tile_rows(100000000), 4);
}

} // namespace
} // namespace shape
