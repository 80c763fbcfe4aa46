// SPDX-License-Identifier: MIT

#include "libshape/linalg/eight_lane_solve.h"

#include <gtest/gtest.h>

#include <vector>

#include "libshape/base/error.h"
#include "libshape/base/random.h"
#include "libshape/base/to_size.h"

namespace shape {
using namespace internal;
namespace {

/// Diagonally dominant with a seeded pattern.
SparseMatrix random_matrix(int size, double density, Random& random)
{
    Eigen::MatrixXd dense = 0.1 * Eigen::MatrixXd::Identity(size, size);
    for (int row = 0; row < size; ++row)
        for (int column = 0; column < row; ++column)
            if (random.uniform() < density) {
                const double value = random.normal();
                dense(row, column) = dense(column, row) = value;
                dense(row, row) += std::abs(value);
                dense(column, column) += std::abs(value);
            }
    return dense.sparseView();
}

TEST(EightLaneSolve, LeavesNoResidualInAnyOf24Columns)
{
    for (unsigned seed = 1; seed <= 5; ++seed) {
        Random random(seed);
        const int size = seed == 1 ? 1 : static_cast<int>(20 * seed);
        const SparseMatrix matrix = random_matrix(size, 0.1, random);
        EightLanePoints x(to_size(size));
        std::vector<Eigen::MatrixXd> rhs(EightLanes::lanes, Eigen::MatrixXd(size, 3));
        const auto numbers_of = [&](std::size_t v, int k) {
            return std::array<float*, 3>{&x[v].x.of[k], &x[v].y.of[k], &x[v].z.of[k]};
        };
        for (int k = 0; k < EightLanes::lanes; ++k)
            for (int v = 0; v < size; ++v)
                for (std::size_t c = 0; c < 3; ++c) {
                    const auto value = static_cast<float>(random.uniform(-1.0, 1.0));
                    *numbers_of(to_size(v), k)[c] = value;
                    rhs[to_size(k)](v, static_cast<int>(c)) = value;
                }
        EightLaneSolve(matrix).solve(x);
        for (int k = 0; k < EightLanes::lanes; ++k) {
            Eigen::MatrixXd solution(size, 3);
            for (int v = 0; v < size; ++v)
                for (std::size_t c = 0; c < 3; ++c)
                    solution(v, static_cast<int>(c)) = *numbers_of(to_size(v), k)[c];
            const double scale = solution.cwiseAbs().maxCoeff() * Eigen::MatrixXd(matrix).norm();
            EXPECT_LT((matrix * solution - rhs[to_size(k)]).cwiseAbs().maxCoeff(), 1e-6 * scale);
        }
    }
}

TEST(EightLaneSolve, NamesAMatrixThatIsNotPositiveDefinite)
{
    SparseMatrix matrix(2, 2);
    matrix.insert(0, 0) = 1.0;
    matrix.insert(1, 1) = -1.0;
    EXPECT_THROW(EightLaneSolve{matrix}, NumericalError);
}

} // namespace
} // namespace shape
