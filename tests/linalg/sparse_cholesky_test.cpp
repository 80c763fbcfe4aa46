// SPDX-License-Identifier: MIT

#include "libshape/linalg/sparse_cholesky.h"

#include <gtest/gtest.h>

#include <thread>
#include <vector>

#include "libshape/base/error.h"
#include "libshape/base/threads.h"
#include "tests/support/matrices.h"
#include "tests/support/thread_scope.h"

namespace shape {
using namespace internal;
namespace {

/// Five-point Laplacian of a rows by columns grid plus `shift` on the diagonal.
SparseMatrix grid_laplacian(int rows, int columns, double shift)
{
    std::vector<Eigen::Triplet<double>> entries;
    const auto connect = [&](int a, int b) {
        entries.insert(entries.end(), {{a, a, 1.0}, {b, b, 1.0}, {a, b, -1.0}, {b, a, -1.0}});
    };
    for (int r = 0; r < rows; ++r)
        for (int c = 0; c < columns; ++c) {
            const int i = r * columns + c;
            entries.emplace_back(i, i, shift);
            if (c + 1 < columns)
                connect(i, i + 1);
            if (r + 1 < rows)
                connect(i, i + columns);
        }
    SparseMatrix matrix(rows * columns, rows * columns);
    matrix.setFromTriplets(entries.begin(), entries.end());
    return matrix;
}

TEST(SparseCholesky, SolvesForAnyNumberOfRightHandSides)
{
    const SparseMatrix matrix = grid_laplacian(30, 40, 0.1);
    for (const Ordering ordering : {Ordering::MinimumDegree, Ordering::NestedDissection}) {
        const SparseCholesky factor(matrix, ordering);
        EXPECT_EQ(factor.size(), 1200);
        for (const int columns : {0, 1, 3, 7}) {
            const Eigen::MatrixXd rhs = test::random_matrix(1200, columns, 4);
            const Eigen::MatrixXd solution = factor.solve(rhs);
            ASSERT_EQ(solution.cols(), columns);
            EXPECT_LE((matrix * solution - rhs).norm(), 1e-12 * rhs.norm());
        }
    }
}

TEST(SparseCholesky, IsTheSameHoweverManyAreMadeAtOnce)
{
    const SparseMatrix matrix = grid_laplacian(40, 50, 0.1);
    const Eigen::MatrixXd rhs = test::random_matrix(2000, 1, 5);
    const Eigen::MatrixXd alone = SparseCholesky(matrix, Ordering::NestedDissection).solve(rhs);
    std::vector<Eigen::MatrixXd> found(16);
    std::vector<std::thread> threads;
    for (Eigen::MatrixXd& solution : found)
        threads.emplace_back(
            [&] { solution = SparseCholesky(matrix, Ordering::NestedDissection).solve(rhs); });
    for (std::thread& thread : threads)
        thread.join();
    for (const Eigen::MatrixXd& solution : found)
        EXPECT_EQ(solution, alone);
}

TEST(SparseCholesky, SolvesTheTridiagonalSystemInClosedForm)
{
    // -u'' = 1 between two zeros: u_i = i (n + 1 - i) / 2 is exact for differences too.
    const int n = 500;
    SparseMatrix matrix = grid_laplacian(1, n, 0.0);
    matrix.coeffRef(0, 0) += 1.0;
    matrix.coeffRef(n - 1, n - 1) += 1.0;
    const SparseCholesky factor(matrix);
    const Eigen::MatrixXd solution = factor.solve(Eigen::VectorXd::Ones(n));
    // Condition number 1e5, largest entry 3e4.
    for (int i = 1; i <= n; ++i)
        EXPECT_NEAR(solution(i - 1, 0), 0.5 * i * (n + 1 - i), 1e-11 * 3e4);
}

TEST(SparseCholesky, CountsTheEntriesOfTheFactor)
{
    // A path has an order without fill: n diagonal and n - 1 other entries.
    EXPECT_EQ(SparseCholesky(grid_laplacian(1, 50, 1.0), Ordering::MinimumDegree).nonzeros(), 99u);
}

TEST(SparseCholesky, ReadsTheLowerTriangleOnly)
{
    const SparseMatrix matrix = grid_laplacian(9, 9, 1.0);
    const SparseMatrix lower = matrix.triangularView<Eigen::Lower>();
    const Eigen::MatrixXd rhs = test::random_matrix(81, 2, 5);
    EXPECT_EQ(SparseCholesky(lower).solve(rhs), SparseCholesky(matrix).solve(rhs));
}

TEST(SparseCholesky, RefactorsOtherValuesOnTheSamePattern)
{
    SparseCholesky factor(grid_laplacian(12, 10, 1.0));
    const SparseMatrix other = 3.0 * grid_laplacian(12, 10, 0.01);
    const Eigen::MatrixXd rhs = test::random_matrix(120, 2, 6);
    factor.refactor(other);
    EXPECT_EQ(factor.solve(rhs), SparseCholesky(other).solve(rhs));
}

TEST(SparseCholesky, RefusesWhatIsNotPositiveDefinite)
{
    EXPECT_THROW(SparseCholesky(grid_laplacian(5, 5, -0.5)), NumericalError);
    SparseMatrix negative(1, 1);
    negative.insert(0, 0) = -1.0;
    negative.makeCompressed();
    EXPECT_THROW(SparseCholesky{negative}, NumericalError);
}

TEST(SparseCholesky, SolvesNothingAfterAFailedRefactoringUntilOneSucceeds)
{
    const SparseMatrix good = grid_laplacian(20, 20, 0.5);
    const Eigen::MatrixXd rhs = test::random_matrix(400, 1, 7);
    SparseCholesky factor(good);
    const Eigen::MatrixXd solution = factor.solve(rhs);
    EXPECT_THROW(factor.refactor(grid_laplacian(20, 20, -0.5)), NumericalError);
    EXPECT_THROW((void)factor.solve(rhs), NumericalError);
    factor.refactor(good);
    EXPECT_EQ(factor.solve(rhs), solution);
}

TEST(SparseCholesky, RefusesOtherSizes)
{
    EXPECT_THROW(SparseCholesky(SparseMatrix(3, 4)), InvalidInput);
    EXPECT_THROW(SparseCholesky{SparseMatrix()}, InvalidInput);
    SparseCholesky factor(grid_laplacian(4, 4, 1.0));
    EXPECT_THROW((void)factor.solve(Eigen::VectorXd::Ones(15)), InvalidInput);
    EXPECT_THROW(factor.refactor(grid_laplacian(4, 5, 1.0)), InvalidInput);
    SparseMatrix diagonal(16, 16);
    diagonal.setIdentity();
    EXPECT_THROW(factor.refactor(diagonal), InvalidInput);
}

TEST(SparseCholesky, GivesTheSameBitsToConcurrentSolves)
{
    const test::ThreadScope scope(4);
    const SparseCholesky factor(grid_laplacian(40, 40, 0.1));
    const Eigen::MatrixXd rhs = test::random_matrix(1600, 3, 8);
    const Eigen::MatrixXd alone = factor.solve(rhs);
    std::vector<Eigen::MatrixXd> solutions(64);
    parallel_for(solutions.size(), 1,
                 [&](std::size_t begin, std::size_t) { solutions[begin] = factor.solve(rhs); });
    for (const Eigen::MatrixXd& solution : solutions)
        EXPECT_EQ(solution, alone);
}

} // namespace
} // namespace shape
