// SPDX-License-Identifier: MIT

#include "libshape/linalg/packed_cholesky.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <vector>

#include "libshape/base/error.h"
#include "libshape/base/random.h"
#include "libshape/base/to_size.h"

namespace shape {
using namespace internal;
namespace {

struct System
{
    Eigen::VectorXd diagonal;
    std::vector<SymmetricEntry> entries;

    [[nodiscard]] Eigen::MatrixXd dense() const
    {
        Eigen::MatrixXd matrix = diagonal.asDiagonal();
        for (const auto& [row, column, value] : entries)
            matrix(row, column) = matrix(column, row) = value;
        return matrix;
    }
};

/// Diagonally dominant with a seeded pattern.
System random_system(int size, double density, Random& random)
{
    System system{Eigen::VectorXd::Constant(size, 0.1), {}};
    for (int row = 0; row < size; ++row)
        for (int column = 0; column < row; ++column)
            if (random.uniform() < density) {
                const double value = random.normal();
                system.entries.push_back({row, column, value});
                system.diagonal[row] += std::abs(value);
                system.diagonal[column] += std::abs(value);
            }
    return system;
}

TEST(PackedCholesky, SolvesEverySystemAsTheDenseFactorisationDoes)
{
    Random random(1);
    PackedCholesky factors;
    std::vector<System> systems;
    for (const int size : {1, 2, 7, 20, 60, 150}) {
        for (const double density : {0.0, 3.0 / size, 1.0}) {
            systems.push_back(random_system(size, density, random));
            EXPECT_EQ(factors.add(systems.back().diagonal, systems.back().entries),
                      systems.size() - 1);
        }
    }
    for (std::size_t i = 0; i < systems.size(); ++i) {
        const Eigen::Index size = systems[i].diagonal.size();
        std::vector<Eigen::Vector4d> x(to_size(size));
        Eigen::MatrixXd rhs(size, 4);
        for (Eigen::Index row = 0; row < size; ++row) {
            rhs.row(row) << random.normal(), random.normal(), random.normal(), 0.0;
            x[to_size(row)] = rhs.row(row).transpose();
        }
        factors.solve(i, x.data());
        const Eigen::MatrixXd expected = systems[i].dense().ldlt().solve(rhs);
        for (Eigen::Index row = 0; row < size; ++row)
            EXPECT_LT((x[to_size(row)] - expected.row(row).transpose()).norm(),
                      1e-11 * (1.0 + expected.norm()));
    }
}

TEST(PackedCholesky, FillsNothingInAChainEliminatedFromItsEnd)
{
    PackedCholesky factors;
    std::vector<SymmetricEntry> chain;
    for (int i = 1; i < 10; ++i)
        chain.push_back({i, i - 1, -1.0});
    (void)factors.add(Eigen::VectorXd::Constant(10, 2.0), chain);
    EXPECT_EQ(factors.nonzeros(), 9U);
}

TEST(PackedCholesky, RefusesWhatIsNotPositiveDefinite)
{
    PackedCholesky factors;
    const std::vector<SymmetricEntry> entry{{1, 0, 2.0}};
    EXPECT_THROW((void)factors.add(Eigen::Vector2d(1.0, 1.0), entry), NumericalError);
    EXPECT_THROW((void)factors.add(Eigen::Vector2d(0.0, 1.0), {}), NumericalError);
    EXPECT_EQ(factors.add(Eigen::Vector2d(1.0, 5.0), entry), 0U); // it is as if nothing had been
    std::vector<Eigen::Vector4d> x{{1, 0, 0, 0}, {0, 0, 0, 0}};
    factors.solve(0, x.data());
    EXPECT_NEAR(x[0][0], 5.0, 1e-15);
    EXPECT_NEAR(x[1][0], -2.0, 1e-15);
}

} // namespace
} // namespace shape
