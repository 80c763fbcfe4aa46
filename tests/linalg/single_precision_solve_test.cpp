// SPDX-License-Identifier: MIT

#include "libshape/linalg/single_precision_solve.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>

#include "libshape/base/error.h"
#include "libshape/base/random.h"
#include "tests/support/lane_vectors.h"
#include "tests/support/thread_scope.h"

namespace shape {
using namespace internal;
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

/// What preconditions for a grid's Laplacian, column by column, times that Laplacian.
Eigen::MatrixXd preconditioned(const SparseMatrix& matrix)
{
    const SinglePrecisionSolve solve{SparseCholesky(matrix)};
    Eigen::MatrixXd columns(matrix.rows(), matrix.cols());
    LaneVectors found;
    LaneVectors workspace;
    for (Eigen::Index c = 0; c < matrix.cols(); ++c) {
        LaneVectors unit = LaneVectors::Zero(4, matrix.cols());
        unit(c % 3, c) = 1.0F;
        const double product = solve.precondition(unit, found, workspace);
        EXPECT_FLOAT_EQ(static_cast<float>(product), found(c % 3, c));
        columns.col(c) = found.row(c % 3).cast<double>();
    }
    EXPECT_LT((columns - columns.transpose()).norm(), 1e-6 * columns.norm());
    return columns * matrix.selfadjointView<Eigen::Lower>();
}

TEST(SinglePrecisionSolve, PreconditionsNearlyAsWellAsItSolves)
{
    for (const int side : {1, 2, 5, 17, 24}) {
        SCOPED_TRACE(side);
        const Eigen::VectorXcd values = preconditioned(grid_matrix(side, 7)).eigenvalues();
        EXPECT_LT(values.imag().cwiseAbs().maxCoeff(), 1e-4);
        EXPECT_GT(values.real().minCoeff(), 0.97);
        EXPECT_LT(values.real().maxCoeff(), 1.03);
    }
}

TEST(SinglePrecisionSolve, PreconditioningKeepsConstants)
{
    constexpr int side = 150;
    SparseMatrix matrix = grid_matrix(side, 8);
    // A Laplacian held at one vertex, pulled there: the solution is constant.
    const Eigen::VectorXd sums =
        matrix.selfadjointView<Eigen::Lower>() * Eigen::VectorXd::Ones(matrix.cols());
    for (int c = 1; c < matrix.cols(); ++c)
        matrix.coeffRef(c, c) -= sums[c];
    LaneVectors pull = LaneVectors::Zero(4, matrix.cols());
    pull(1, 0) = static_cast<float>(sums[0]);
    LaneVectors found;
    LaneVectors workspace;
    (void)SinglePrecisionSolve{SparseCholesky(matrix)}.precondition(pull, found, workspace);
    Eigen::ArrayXd solution = found.row(1).cast<double>();
    EXPECT_NEAR(solution.mean(), 1.0, 0.01);
    // Rounding of the last columns, which hold everything, and near the held vertex remains.
    std::sort(solution.begin(), solution.end());
    const Eigen::Index tenth = solution.size() / 10;
    EXPECT_LT(solution[9 * tenth] - solution[tenth], 1e-3);
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
    EXPECT_THROW(solve.precondition(LaneVectors::Ones(4, 8), found, workspace), InvalidInput);
    EXPECT_THROW(SinglePrecisionSolve(SparseCholesky(grid_matrix(3, 1), Ordering::MinimumDegree)),
                 InvalidInput);
}

} // namespace
} // namespace shape
