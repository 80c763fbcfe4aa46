// SPDX-License-Identifier: MIT

#include "libshape/statistics/block_krylov.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>

#include "libshape/base/error.h"
#include "libshape/statistics/principal_components.h"
#include "tests/support/matrices.h"
#include "tests/support/thread_scope.h"

namespace shape {
using namespace internal;
namespace {

using Eigen::Index;

constexpr std::uint64_t plenty = std::uint64_t{1} << 30;

void pass(BlockKrylov& krylov, const RowMatrix& data)
{
    const Index step = 64;
    for (Index first = 0; first < data.rows(); first += step) {
        RowMatrix rows = data.middleRows(first, std::min(step, data.rows() - first));
        krylov.add(first, rows);
    }
    krylov.end_pass();
    if (krylov.passes() > 1 || krylov.is_complete())
        return;
    if (const std::vector<Index> rows = krylov.outlying_rows(); !rows.empty())
        krylov.add_directions(data(rows, Eigen::all));
}

BlockKrylov run(const RowMatrix& data, const BlockKrylovOptions& options)
{
    BlockKrylov krylov(data.rows(), data.cols(), options);
    while (!krylov.is_complete() && krylov.passes() < 200)
        pass(krylov, data);
    EXPECT_TRUE(krylov.is_complete());
    return krylov;
}

/// N rows of E numbers, about a mean that is not 0, whose covariance (divisor N - 1) has exactly these
/// eigenvalues.
RowMatrix planted(Index rows, const Eigen::VectorXd& variances, Index columns, unsigned seed)
{
    const Index count = variances.size();
    RowMatrix scores = test::random_matrix(rows, count, seed);
    scores.rowwise() -= scores.colwise().mean().eval();
    const Eigen::HouseholderQR<Eigen::MatrixXd> left(scores);
    const Eigen::HouseholderQR<Eigen::MatrixXd> right(
        test::random_matrix(columns, count, seed + 1));
    const Eigen::MatrixXd u = left.householderQ() * Eigen::MatrixXd::Identity(rows, count);
    const Eigen::MatrixXd v = right.householderQ() * Eigen::MatrixXd::Identity(columns, count);
    RowMatrix data =
        u * (static_cast<double>(rows - 1) * variances).cwiseSqrt().asDiagonal() * v.transpose();
    return data.rowwise() + test::random_matrix(1, columns, seed + 2).row(0);
}

/// Variances of the rows along the components, as Rayleigh quotients.
Eigen::VectorXd variances_along(const RowMatrix& data, const RowMatrix& components)
{
    const RowMatrix centred = data.rowwise() - data.colwise().mean();
    return (centred * components.transpose()).colwise().squaredNorm().transpose() /
           static_cast<double>(data.rows() - 1);
}

/// Spectra as they occur: a few modes over noise, a slow decay, equal variances, a jump.
std::vector<Eigen::VectorXd> spectra()
{
    std::vector<Eigen::VectorXd> all;
    const auto add = [&](const auto& variance) {
        Eigen::VectorXd& values = all.emplace_back(200);
        for (Index k = 0; k < values.size(); ++k)
            values[k] = variance(static_cast<double>(k));
    };
    add([](double k) { return k < 12 ? std::pow(0.7, k) : 1e-6; });
    add([](double k) { return 1.0 / ((1.0 + k) * (1.0 + k)); });
    add([](double k) { return std::pow(0.97, k); });
    add([](double k) { return k < 5 ? 1.0 : k < 15 ? 0.5 : 0.01 * std::pow(0.99, k); });
    add([](double k) { return k < 10 ? std::pow(10.0, -k) : 1e-12; });
    return all;
}

TEST(BlockKrylov, FindsPlantedVariancesWithinTheToleranceItReports)
{
    for (const Eigen::VectorXd& spectrum : spectra())
        for (const double tolerance : {1e-3, 1e-6, 1e-9}) {
            const RowMatrix data = planted(400, spectrum, 500, 7);
            const BlockKrylov krylov =
                run(data, {.components = 10, .tolerance = tolerance, .memory = plenty});
            const RowMatrix components = krylov.components();
            ASSERT_EQ(components.rows(), 10);
            EXPECT_TRUE((components * components.transpose()).isIdentity(1e-11));
            const double rounding =
                4.0 * std::numeric_limits<double>::epsilon() * spectrum[0] / spectrum[9];
            EXPECT_LE(krylov.error(), std::max(tolerance, 1.01 * rounding));
            EXPECT_GE(krylov.error(), 0.99 * rounding);
            const Eigen::VectorXd found = variances_along(data, components);
            for (Index k = 0; k < 10; ++k)
                EXPECT_NEAR(found[k], spectrum[k], tolerance * spectrum[k] + 1e-13 * spectrum[0])
                    << k;
            EXPECT_NEAR(krylov.squared_norm(), 399.0 * spectrum.sum(),
                        1e-10 * 399.0 * spectrum.sum());
        }
}

TEST(BlockKrylov, ReportsNoErrorBelowRoundingNorThatOfComponentsThatAreRounding)
{
    const Eigen::VectorXd spectrum = (Eigen::VectorXd(4) << 1.0, 0.5, 0.1, 0.01).finished();
    const BlockKrylov krylov =
        run(planted(200, spectrum, 300, 3), {.components = 7, .memory = plenty});
    const double rounding = 4.0 * std::numeric_limits<double>::epsilon() * 100.0;
    EXPECT_NEAR(krylov.error(), rounding, 0.01 * rounding); // the rows have no fifth component
}

/// As run(), from a start that these rows give.
BlockKrylov run_from(const RowMatrix& sample, const RowMatrix& data,
                     const BlockKrylovOptions& options)
{
    BlockKrylov krylov(data.rows(), data.cols(), options);
    krylov.start_from(sample);
    while (!krylov.is_complete() && krylov.passes() < 200)
        pass(krylov, data);
    return krylov;
}

TEST(BlockKrylovSlow, FindsVariancesFarBelowTheLargest)
{
    // Rows in tight groups, as of subjects scanned again and again; more modes are asked for than there are groups.
    const RowMatrix groups = test::random_matrix(50, 2400, 21);
    const RowMatrix noise = test::random_matrix(1800, 2400, 22);
    constexpr double deviation = 3e-4;
    RowMatrix data = deviation * noise;
    for (Index row = 0; row < data.rows(); ++row)
        data.row(row) += groups.row(row * (row + 1) / 2 % 47 + row % 4);
    const Eigen::VectorXd expected = principal_components(data, {.modes = 55}).variances;
    const BlockKrylov krylov =
        run_from(data.topRows(132), data, {.components = 55, .memory = plenty});
    const Eigen::VectorXd found = variances_along(data, krylov.components());
    for (Index k = 0; k < 55; ++k)
        EXPECT_NEAR(found[k], expected[k], std::max(1e-6, krylov.error()) * expected[k]) << k;
    EXPECT_LE(krylov.passes(), 40);
}

TEST(BlockKrylov, FromSomeOfTheRowsItIsThereSooner)
{
    int passes = 0, passes_at_random = 0;
    for (const Eigen::VectorXd& spectrum : spectra()) {
        const RowMatrix data = planted(400, spectrum, 500, 7);
        const BlockKrylovOptions options{.components = 10, .memory = plenty};
        const BlockKrylov krylov = run_from(data(Eigen::seq(0, 399, 8), Eigen::all), data, options);
        const Eigen::VectorXd found = variances_along(data, krylov.components());
        for (Index k = 0; k < 10; ++k)
            EXPECT_NEAR(found[k], spectrum[k], 1e-6 * spectrum[k] + 1e-13 * spectrum[0]) << k;
        EXPECT_NEAR(krylov.squared_norm(), 399.0 * spectrum.sum(), 1e-10 * 399.0 * spectrum.sum());
        passes += krylov.passes();
        passes_at_random += run(data, options).passes();
    }
    EXPECT_LT(passes, passes_at_random);
}

TEST(BlockKrylov, FindsWhatTheRowsOfTheStartLack)
{
    const Eigen::VectorXd spectrum = spectra()[2];
    const RowMatrix data = planted(400, spectrum, 500, 13);
    const Eigen::MatrixXd leading = principal_components(data, {.modes = 3}).modes.transpose();
    RowMatrix sample = data(Eigen::seq(0, 399, 8), Eigen::all);
    sample -= (sample * leading * leading.transpose()).eval();
    for (const RowMatrix& rows :
         {sample, RowMatrix(sample.topRows(2)), RowMatrix(sample.topRows(1))}) {
        const BlockKrylov krylov = run_from(rows, data, {.components = 10, .memory = plenty});
        const Eigen::VectorXd found = variances_along(data, krylov.components());
        for (Index k = 0; k < 10; ++k)
            EXPECT_NEAR(found[k], spectrum[k], 1e-6 * spectrum[k]) << k;
    }
}

TEST(BlockKrylov, DoesNotMissFewRowsFarFromAllOthers)
{
    // Five rows that go the same way, and one another way, none of them in the start.
    const Eigen::VectorXd spectrum = spectra()[2];
    RowMatrix data = planted(400, spectrum, 500, 13);
    const double far = std::sqrt(400.0 * spectrum[0]);
    for (const Index row : {11, 77, 130, 201, 333})
        data.row(row) += far * planted(2, spectrum.head(1), 500, 17).row(0).normalized();
    data.row(250) += 1.5 * far * planted(2, spectrum.head(1), 500, 19).row(0).normalized();
    const PrincipalComponents expected = principal_components(data, {.modes = 3});
    for (const double tolerance : {1e-1, 1e-2, 1e-4}) {
        const BlockKrylov krylov =
            run_from(data(Eigen::seq(0, 399, 8), Eigen::all), data,
                     {.components = 3, .tolerance = tolerance, .memory = plenty});
        const Eigen::VectorXd found = variances_along(data, krylov.components());
        for (Index k = 0; k < 3; ++k)
            EXPECT_NEAR(found[k], expected.variances[k], tolerance * expected.variances[k]) << k;
    }
}

TEST(BlockKrylov, RestartsWhereTheMemoryIsShortAndStillMeetsTheTolerance)
{
    const Eigen::VectorXd spectrum = spectra()[2]; // the slowest
    const RowMatrix data = planted(400, spectrum, 500, 9);
    const std::uint64_t block = 8 * 500 * static_cast<std::uint64_t>(BlockKrylov::block_size(10));
    const BlockKrylov wide = run(data, {.components = 10, .memory = plenty});
    const BlockKrylov tight = run(data, {.components = 10, .memory = 5 * block});
    EXPECT_GT(tight.passes(), wide.passes());
    const Eigen::VectorXd found = variances_along(data, tight.components());
    for (Index k = 0; k < 10; ++k)
        EXPECT_NEAR(found[k], spectrum[k], 1e-6 * spectrum[k]);
    EXPECT_THROW(BlockKrylov(400, 500, {.components = 10, .memory = 4 * block}), LimitExceeded);
}

TEST(BlockKrylov, KeepsAsManyAsHaveTheShareOfTheVariance)
{
    const Eigen::VectorXd spectrum = spectra()[2];
    const RowMatrix data = planted(400, spectrum, 500, 11);
    for (const double share : {0.2, 0.5, 0.9}) {
        const Index expected = principal_components(data, {.variance = share}).variances.size();
        EXPECT_EQ(run(data, {.variance = share, .memory = plenty}).components().rows(), expected);
    }
    const std::uint64_t little = 8 * 500 * 42 * 5;
    const std::string message = [&] {
        try {
            (void)run(data, {.variance = 0.999, .memory = little});
        } catch (const LimitExceeded& error) {
            return std::string(error.what());
        }
        return std::string();
    }();
    EXPECT_NE(message.find("needs more than"), std::string::npos) << message;
}

TEST(BlockKrylov, EndsWhereTheRowsSpanLessThanIsAskedFor)
{
    Eigen::VectorXd spectrum(4);
    spectrum << 4.0, 3.0, 2.0, 1.0;
    const RowMatrix data = planted(60, spectrum, 80, 13);
    const BlockKrylov krylov = run(data, {.components = 8, .memory = plenty});
    const Eigen::VectorXd found = variances_along(data, krylov.components());
    for (Index k = 0; k < 4; ++k)
        EXPECT_NEAR(found[k], spectrum[k], 1e-6);
    for (Index k = 4; k < found.size(); ++k)
        EXPECT_LE(found[k], 1e-12);
}

TEST(BlockKrylov, HasTheSameBitsForAnyThreadCountAndAfterEveryBreak)
{
    const RowMatrix data = planted(300, spectra()[1], 5000, 15);
    const BlockKrylovOptions options{.components = 10, .memory = plenty};
    const RowMatrix components = run(data, options).components();
    {
        const test::ThreadScope scope(1);
        EXPECT_TRUE(run(data, options).components() == components);
    }
    const test::ThreadScope scope(3);
    BlockKrylov krylov(data.rows(), data.cols(), options);
    while (true) {
        pass(krylov, data);
        if (krylov.is_complete())
            break;
        PassState state;
        krylov.release(state);
        BlockKrylov next(data.rows(), data.cols(), options);
        PassStateReader reader(std::move(state));
        next.restore(reader);
        krylov = std::move(next);
    }
    EXPECT_TRUE(krylov.components() == components);
    EXPECT_FALSE(run(data, {.components = 10, .seed = 2, .memory = plenty}).components() ==
                 components);
}

} // namespace
} // namespace shape
