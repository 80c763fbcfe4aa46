// SPDX-License-Identifier: MIT

#include "libshape/statistics/inner_products.h"

#include <gtest/gtest.h>

#include <limits>

#include "libshape/base/error.h"
#include "tests/support/matrices.h"
#include "tests/support/thread_scope.h"

namespace shape {
namespace {

Eigen::MatrixXd distances_of_rows(const RowMatrix& data)
{
    Eigen::MatrixXd distances(data.rows(), data.rows());
    for (Eigen::Index i = 0; i < data.rows(); ++i)
        for (Eigen::Index j = 0; j < data.rows(); ++j)
            distances(i, j) = (data.row(i) - data.row(j)).norm();
    return distances;
}

TEST(InnerProducts, AreThoseOfTheRows)
{
    const RowMatrix data = test::random_matrix(210, 17, 1); // more than two tiles
    const Eigen::MatrixXd products = inner_products(data);
    EXPECT_LE((products - data * data.transpose()).cwiseAbs().maxCoeff(), 1e-13);
    EXPECT_EQ(products, products.transpose().eval());
}

TEST(InnerProducts, AboutTheMeanDoNotKnowTheOrigin)
{
    const RowMatrix data = test::random_matrix(12, 5, 2);
    const RowMatrix moved = data.rowwise() + test::random_matrix(1, 5, 3).row(0);
    const Eigen::MatrixXd products = centred_inner_products(data);
    EXPECT_LE((products - centred_inner_products(moved)).cwiseAbs().maxCoeff(), 1e-13);
    EXPECT_LE(products.colwise().sum().cwiseAbs().maxCoeff(), 1e-13);
    EXPECT_THROW((void)centred_inner_products(RowMatrix(0, 3)), InvalidInput);
}

TEST(InnerProducts, FollowFromDistances)
{
    const RowMatrix data = test::random_matrix(15, 6, 4);
    EXPECT_LE((inner_products_of_distances(distances_of_rows(data)) - centred_inner_products(data))
                  .cwiseAbs()
                  .maxCoeff(),
              1e-13);
}

TEST(InnerProducts, HaveTheSameBitsForAnyThreadCount)
{
    const RowMatrix data = test::random_matrix(230, 40, 5);
    const auto computed = [&](int threads) {
        const test::ThreadScope scope(threads);
        return inner_products(data);
    };
    EXPECT_EQ(computed(1), computed(3));
}

TEST(InnerProducts, RefuseWhatAreNotDistances)
{
    const Eigen::MatrixXd good = distances_of_rows(test::random_matrix(4, 3, 6));
    Eigen::MatrixXd skew = good;
    skew(2, 1) += 0.1;
    Eigen::MatrixXd diagonal = good;
    diagonal(3, 3) = 0.1;
    Eigen::MatrixXd infinite = good;
    infinite(1, 0) = infinite(0, 1) = std::numeric_limits<double>::infinity();
    for (const Eigen::MatrixXd& bad :
         {skew, diagonal, infinite, Eigen::MatrixXd(good.topRows(3)), Eigen::MatrixXd(0, 0)})
        EXPECT_THROW((void)inner_products_of_distances(bad), InvalidInput);
}

} // namespace
} // namespace shape
