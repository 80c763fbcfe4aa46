// SPDX-License-Identifier: MIT

#include "libshape/linalg/symmetric_eigen.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "tests/support/matrices.h"

namespace shape {
using namespace internal;
namespace {

/// The pairs must have the known values, solve A v = lambda v and be orthonormal.
void expect_leading(const Eigen::MatrixXd& matrix, const Eigen::VectorXd& spectrum, int count)
{
    Eigen::VectorXd expected = spectrum;
    std::sort(expected.begin(), expected.end(), std::greater<>());
    const Eigenpairs pairs = largest_eigenpairs(matrix, count);
    const double tolerance = 1e-12 * spectrum.cwiseAbs().maxCoeff();
    ASSERT_EQ(pairs.values.size(), count);
    EXPECT_LE((pairs.values - expected.head(count)).cwiseAbs().maxCoeff(), tolerance);
    EXPECT_LE((matrix * pairs.vectors - pairs.vectors * pairs.values.asDiagonal()).norm(),
              10.0 * tolerance);
    EXPECT_TRUE((pairs.vectors.transpose() * pairs.vectors).isIdentity(1e-11));
}

Eigen::MatrixXd with_spectrum(const Eigen::VectorXd& spectrum, unsigned seed)
{
    const Eigen::MatrixXd q = test::random_orthogonal(spectrum.size(), seed);
    return q * spectrum.asDiagonal() * q.transpose();
}

Eigen::VectorXd spectrum_of(int size, const std::function<double(int)>& value)
{
    Eigen::VectorXd spectrum(size);
    for (int i = 0; i < size; ++i)
        spectrum[i] = value(i);
    return spectrum;
}

TEST(LargestEigenpairs, AreThoseOfThePathGraphInClosedForm)
{
    // Laplacian of a path of n vertices: eigenvalues 2 - 2 cos(pi k / n).
    for (const int n : {2, 5, 50, 200}) {
        Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(n, n);
        for (int i = 0; i + 1 < n; ++i)
            matrix.block<2, 2>(i, i) += (Eigen::Matrix2d() << 1, -1, -1, 1).finished();
        const Eigen::VectorXd spectrum =
            spectrum_of(n, [&](int k) { return 2.0 - 2.0 * std::cos(std::numbers::pi * k / n); });
        for (const int count : {1, 2, 10, n})
            if (count <= n)
                expect_leading(matrix, spectrum, count);
    }
}

TEST(LargestEigenpairs, FindEveryCopyOfAMultipleEigenvalue)
{
    for (const int n : {60, 200})
        for (const int count : {1, 3, 8}) {
            SCOPED_TRACE(join(count, " of ", n));
            const auto expect = [&](const std::function<double(int)>& value) {
                const Eigen::VectorXd spectrum = spectrum_of(n, value);
                expect_leading(with_spectrum(spectrum, 5), spectrum, count);
            };
            expect([](int) { return 1.0; });
            expect([](int i) { return std::pow(0.8, i / 2); });
            expect([](int i) { return std::pow(0.5, i / 3); });
            expect([](int i) { return i < 10 ? 1.0 : 0.9; });
            expect([](int i) { return i < 2 ? 1.0 : 1e-3 * std::pow(0.9, i); });
        }
}

TEST(LargestEigenpairs, SurviveLowRank)
{
    for (const int n : {60, 200})
        for (const int rank : {0, 1, 4}) {
            const Eigen::VectorXd spectrum =
                spectrum_of(n, [&](int i) { return i < rank ? 1.0 / (1.0 + i) : 0.0; });
            expect_leading(with_spectrum(spectrum, 6), spectrum, 8);
        }
}

TEST(LargestEigenpairs, AreTheLargestNotTheLargestInMagnitude)
{
    const Eigen::VectorXd spectrum = spectrum_of(100, [](int i) { return 3.0 - i; });
    expect_leading(with_spectrum(spectrum, 7), spectrum, 6);
}

TEST(LargestEigenpairs, ScaleWithTheMatrixBitForBit)
{
    const Eigen::MatrixXd matrix =
        with_spectrum(spectrum_of(80, [](int i) { return std::pow(0.7, i); }), 8);
    const Eigenpairs plain = largest_eigenpairs(matrix, 5);
    for (const int exponent : {-200, 300}) {
        const double factor = std::ldexp(1.0, exponent);
        const Eigenpairs scaled = largest_eigenpairs(factor * matrix, 5);
        EXPECT_EQ(scaled.values, factor * plain.values);
        EXPECT_EQ(scaled.vectors, plain.vectors);
    }
}

TEST(LargestEigenpairs, ReadTheLowerTriangleOnly)
{
    for (const int size : {10, 100}) {
        const Eigen::VectorXd spectrum = spectrum_of(size, [](int i) { return 1.0 / (i + 1); });
        const Eigen::MatrixXd matrix = with_spectrum(spectrum, 9);
        const Eigen::MatrixXd lower = matrix.triangularView<Eigen::Lower>();
        EXPECT_LE((largest_eigenpairs(lower, 4).values - spectrum.head(4)).norm(), 1e-13);
    }
}

TEST(LargestEigenpairs, RefuseBrokenInput)
{
    Eigen::MatrixXd matrix = Eigen::MatrixXd::Identity(4, 4);
    EXPECT_THROW((void)largest_eigenpairs(matrix, 0), InvalidInput);
    EXPECT_THROW((void)largest_eigenpairs(matrix, 5), InvalidInput);
    EXPECT_THROW((void)largest_eigenpairs(matrix.topRows(3), 1), InvalidInput);
    EXPECT_THROW((void)largest_eigenpairs(Eigen::MatrixXd(), 1), InvalidInput);
    matrix(2, 1) = std::numeric_limits<double>::quiet_NaN();
    EXPECT_THROW((void)largest_eigenpairs(matrix, 1), InvalidInput);
}

} // namespace
} // namespace shape
