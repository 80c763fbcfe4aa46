// SPDX-License-Identifier: MIT

#include "libshape/linalg/single_precision_solve.h"

#include <gtest/gtest.h>

#include "libshape/base/error.h"
#include "libshape/base/random.h"
#include "tests/support/lane_vectors.h"
#include "tests/support/thread_scope.h"

namespace shape {
namespace {

/// A grid's Laplacian with a random positive diagonal added: fills in, has wide supernodes.
SparseMatrix grid_matrix(int side, std::uint64_t seed)
{
    Random random(seed);
    std::vector<Eigen::Triplet<double>> entries;
    Eigen::VectorXd diagonal =
        Eigen::VectorXd::NullaryExpr(side * side, [&] { return random.uniform(0.01, 1.0); });
    const auto connect = [&](int i, int j) {
        const double weight = random.uniform(0.1, 2.0);
        entries.emplace_back(std::max(i, j), std::min(i, j), -weight);
        diagonal[i] += weight;
        diagonal[j] += weight;
    };
    for (int y = 0; y < side; ++y)
        for (int x = 0; x < side; ++x) {
            if (x + 1 < side)
                connect(y * side + x, y * side + x + 1);
            if (y + 1 < side)
                connect(y * side + x, (y + 1) * side + x);
        }
    for (int i = 0; i < side * side; ++i)
        entries.emplace_back(i, i, diagonal[i]);
    SparseMatrix matrix(side * side, side * side);
    matrix.setFromTriplets(entries.begin(), entries.end());
    return matrix;
}

TEST(SinglePrecisionSolve, SolvesAsExactlyAsFloatAllows)
{
    for (const int side : {1, 2, 5, 17, 60, 150}) // the last one in subtrees
        for (const Ordering ordering : {Ordering::MinimumDegree, Ordering::NestedDissection}) {
            if (ordering == Ordering::MinimumDegree && side * side < 3000)
                continue; // no supernodes
            SCOPED_TRACE(side);
            const SparseMatrix matrix = grid_matrix(side, 3);
            Random random(4);
            const Eigen::VectorXd solution = Eigen::VectorXd::NullaryExpr(
                3 * side * side, [&] { return random.uniform(-1.0, 1.0); });
            Eigen::VectorXd rhs(solution.size());
            for (int k = 0; k < 3; ++k) {
                const Eigen::VectorXd column = solution(Eigen::seqN(k, side * side, 3));
                rhs(Eigen::seqN(k, side * side, 3)) =
                    matrix.selfadjointView<Eigen::Lower>() * column;
            }
            const SinglePrecisionSolve solve{SparseCholesky(matrix, ordering)};
            LaneVectors found;
            LaneVectors workspace;
            const double product = solve.solve(test::lane_vectors(rhs), found, workspace);
            EXPECT_LT((found - test::lane_vectors(solution)).norm(), 1e-4 * solution.norm());
            EXPECT_NEAR(product, rhs.dot(solution), 1e-4 * rhs.dot(solution));

            const test::ThreadScope threads(3);
            LaneVectors again;
            EXPECT_EQ(solve.solve(test::lane_vectors(rhs), again, workspace), product);
            EXPECT_EQ(found, again);
        }
}

TEST(SinglePrecisionSolve, SolvesWhereTheGraphFallsIntoPieces)
{
    constexpr int side = 90; // each in subtrees of its own
    const SparseMatrix one = grid_matrix(side, 5);
    std::vector<Eigen::Triplet<double>> entries;
    for (int c = 0; c < one.cols(); ++c)
        for (SparseMatrix::InnerIterator i(one, c); i; ++i)
            for (const int shift : {0, side * side})
                entries.emplace_back(static_cast<int>(i.row()) + shift, c + shift, i.value());
    SparseMatrix two(2 * side * side, 2 * side * side);
    two.setFromTriplets(entries.begin(), entries.end());
    Random random(6);
    const LaneVectors rhs = test::random_lane_vectors(two.cols(), random);
    LaneVectors found;
    LaneVectors workspace;
    SinglePrecisionSolve{SparseCholesky(two)}.solve(rhs, found, workspace);
    const Eigen::MatrixXd back =
        two.selfadjointView<Eigen::Lower>() * found.transpose().cast<double>();
    EXPECT_LT((back.transpose() - rhs.cast<double>()).norm(), 1e-4 * rhs.norm());
}

TEST(SinglePrecisionSolve, RefusesAnotherSizeAndFactorsWithoutSupernodes)
{
    const SinglePrecisionSolve solve{SparseCholesky(grid_matrix(3, 1))};
    LaneVectors found;
    LaneVectors workspace;
    EXPECT_THROW(solve.solve(LaneVectors::Ones(4, 8), found, workspace), InvalidInput);
    EXPECT_THROW(SinglePrecisionSolve(SparseCholesky(grid_matrix(3, 1), Ordering::MinimumDegree)),
                 InvalidInput);
}

} // namespace
} // namespace shape
