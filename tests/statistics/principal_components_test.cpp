// SPDX-License-Identifier: MIT

#include "libshape/statistics/principal_components.h"

#include <gtest/gtest.h>

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <vector>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "tests/support/matrices.h"
#include "tests/support/thread_scope.h"

namespace shape {
using namespace internal;
namespace {

using Eigen::Index;

/// Seeded observations whose standard deviations along hidden axes fall by `decay` from axis to
/// axis, around a mean that is not 0.
RowMatrix sample(Index observations, Index variables, double decay, unsigned seed)
{
    RowMatrix data = test::random_matrix(observations, variables, seed);
    for (Index axis = 0; axis < variables; ++axis)
        data.col(axis) *= std::pow(decay, static_cast<double>(axis));
    data = data * test::random_orthogonal(variables, seed + 1);
    return data.rowwise() + test::random_matrix(1, variables, seed + 2).row(0);
}

RowMatrix centred(const RowMatrix& data)
{
    return data.rowwise() - data.colwise().mean();
}

/// What the definition says of any result, kept in part or whole.
void expect_laws(const RowMatrix& data, const PrincipalComponents& result)
{
    const Index count = result.variances.size();
    const RowMatrix x = centred(data);
    const double deviation = std::sqrt(result.variances[0]);
    const auto divisor = static_cast<double>(data.rows() - 1);
    ASSERT_EQ(result.modes.rows(), count);
    EXPECT_TRUE((result.modes * result.modes.transpose()).isIdentity(1e-13));
    EXPECT_LE((result.scores - x * result.modes.transpose()).cwiseAbs().maxCoeff(),
              1e-13 * deviation);
    EXPECT_LE(result.scores.colwise().sum().cwiseAbs().maxCoeff(), 1e-11 * deviation);
    const Eigen::MatrixXd covariance = result.scores.transpose() * result.scores / divisor;
    for (Index k = 0; k < count; ++k) {
        EXPECT_NEAR(covariance(k, k), result.variances[k], 1e-14 * result.variances[k]);
        EXPECT_GT(result.variances[k], 0.0);
        EXPECT_LE(result.variances[k], result.variances[std::max<Index>(k - 1, 0)]);
        for (Index j = 0; j < k; ++j) // scores of different modes are uncorrelated
            EXPECT_LE(std::abs(covariance(j, k)),
                      1e-12 * std::sqrt(result.variances[j] * result.variances[k]));
        Index largest = 0;
        result.modes.row(k).cwiseAbs().maxCoeff(&largest);
        EXPECT_GT(result.modes(k, largest), 0.0);
    }
    EXPECT_NEAR(result.total_variance, x.squaredNorm() / divisor, 1e-14 * result.total_variance);
    EXPECT_LE((result.mean.transpose() - data.colwise().mean()).norm(), 1e-14 * result.mean.norm());
    for (Index k = 0; k < count; ++k)
        EXPECT_LE((result.weights.col(k).transpose() * x - result.modes.row(k)).norm(),
                  1e-13 * deviation / std::sqrt(result.variances[k]));
}

/// Mode k of two results up to sign.
double mode_distance(const PrincipalComponents& a, const RowMatrix& modes, Index k)
{
    return std::min((a.modes.row(k) - modes.row(k)).norm(), (a.modes.row(k) + modes.row(k)).norm());
}

TEST(PrincipalComponents, ObeyTheirLawsOnSeededData)
{
    for (unsigned seed = 1; seed <= 10; ++seed)
        for (const auto& [rows, columns] :
             std::vector<std::pair<Index, Index>>{{2, 5}, {6, 40}, {40, 6}, {25, 25}, {70, 300}})
            for (const int modes : {0, 1, 3}) {
                SCOPED_TRACE(join(rows, " x ", columns, ", modes ", modes, ", seed ", seed));
                if (modes >= rows)
                    continue;
                const RowMatrix data = sample(rows, columns, 0.9, seed);
                const PrincipalComponents result = principal_components(data, {.modes = modes});
                EXPECT_EQ(result.variances.size(), modes > 0 ? modes : std::min(rows - 1, columns));
                expect_laws(data, result);
            }
}

TEST(PrincipalComponents, AgreeWithTheSingularValuesOfTheCentredData)
{
    for (const double decay : {0.95, 0.7}) {
        const RowMatrix data = sample(30, 80, decay, 4);
        const Eigen::JacobiSVD<Eigen::MatrixXd> svd(centred(data),
                                                    Eigen::ComputeThinU | Eigen::ComputeThinV);
        const PrincipalComponents result = principal_components(data);
        ASSERT_EQ(result.variances.size(), 29);
        for (Index k = 0; k < 29; ++k) {
            const double variance = svd.singularValues()[k] * svd.singularValues()[k] / 29.0;
            EXPECT_NEAR(result.variances[k], variance, 1e-10 * variance) << k;
            Eigen::VectorXd scores = svd.singularValues()[k] * svd.matrixU().col(k);
            if (svd.matrixV().col(k).dot(result.modes.row(k)) < 0.0)
                scores = -scores;
            EXPECT_LE((result.scores.col(k) - scores).cwiseAbs().maxCoeff(),
                      1e-9 * std::sqrt(variance))
                << k;
        }
    }
}

TEST(PrincipalComponents, OfAnEllipseAreItsAxes)
{
    // n points at equal angles: variance a^2 n / (2 (n - 1)) along each half-axis a.
    const int n = 50;
    for (const double tilt : {0.0, 0.3, 2.0}) {
        const Eigen::Vector2d major(std::cos(tilt), std::sin(tilt));
        const Eigen::Vector2d minor(-std::sin(tilt), std::cos(tilt));
        RowMatrix data(n, 2);
        for (int i = 0; i < n; ++i) {
            const double angle = 2.0 * std::numbers::pi * i / n;
            data.row(i) = Eigen::RowVector2d(7, -5) + 3.0 * std::cos(angle) * major.transpose() +
                          0.5 * std::sin(angle) * minor.transpose();
        }
        const PrincipalComponents result = principal_components(data);
        EXPECT_LE((result.mean - Eigen::Vector2d(7, -5)).norm(), 1e-14);
        EXPECT_NEAR(result.variances[0], 9.0 * n / (2.0 * (n - 1)), 1e-13);
        EXPECT_NEAR(result.variances[1], 0.25 * n / (2.0 * (n - 1)), 1e-13);
        EXPECT_NEAR(std::abs(result.modes.row(0).dot(major)), 1.0, 1e-14);
    }
}

TEST(PrincipalComponents, OfACircleKeepBothModesOfTheSameVariance)
{
    // A multiple eigenvalue, with enough observations for the iterative method.
    const int n = 120;
    RowMatrix data(n, 3);
    for (int i = 0; i < n; ++i) {
        const double angle = 2.0 * std::numbers::pi * i / n;
        data.row(i) << std::cos(angle), std::sin(angle), 1e-3 * (i % 2);
    }
    const PrincipalComponents result = principal_components(data, {.modes = 2});
    EXPECT_NEAR(result.variances[0], result.variances[1], 1e-13);
    EXPECT_NEAR(result.variances[0], n / (2.0 * (n - 1)), 1e-13);
    expect_laws(data, result);
}

TEST(PrincipalComponents, ReproduceTheDataWhenAllModesAreKept)
{
    const RowMatrix data = sample(20, 60, 0.8, 5);
    const PrincipalComponents result = principal_components(data);
    ASSERT_EQ(result.variances.size(), 19);
    const RowMatrix back = (result.scores * result.modes).rowwise() + result.mean.transpose();
    EXPECT_LE((back - data).cwiseAbs().maxCoeff(), 1e-13);
}

TEST(PrincipalComponents, MoveWithATranslationAndARotationOfTheData)
{
    const RowMatrix data = sample(15, 12, 0.8, 6);
    const PrincipalComponents plain = principal_components(data);
    const Eigen::MatrixXd rotation = test::random_orthogonal(12, 7);
    const Eigen::RowVectorXd shift = test::random_matrix(1, 12, 8);
    const PrincipalComponents moved =
        principal_components((data * rotation.transpose()).rowwise() + shift);
    EXPECT_LE((moved.mean - rotation * plain.mean - shift.transpose()).norm(), 1e-13);
    ASSERT_EQ(moved.variances.size(), plain.variances.size());
    for (Index k = 0; k < plain.variances.size(); ++k) {
        EXPECT_NEAR(moved.variances[k], plain.variances[k], 1e-12 * plain.variances[k]);
        EXPECT_LE(mode_distance(moved, plain.modes * rotation.transpose(), k), 1e-9);
    }
}

TEST(PrincipalComponents, ScaleWithTheData)
{
    const RowMatrix data = sample(15, 12, 0.8, 9);
    const PrincipalComponents plain = principal_components(data);
    for (const double factor : {0x1p-40, 0x1p30}) {
        const PrincipalComponents scaled = principal_components(factor * data);
        EXPECT_EQ(scaled.modes, plain.modes);
        EXPECT_EQ(scaled.scores, factor * plain.scores);
        EXPECT_EQ(scaled.variances, factor * factor * plain.variances);
    }
}

TEST(PrincipalComponents, PermuteTheScoresWithTheObservations)
{
    const RowMatrix data = sample(40, 50, 0.85, 10);
    std::vector<Index> order(40);
    std::iota(order.begin(), order.end(), 0);
    std::rotate(order.begin(), order.begin() + 13, order.end());
    std::swap(order[3], order[30]);
    const PrincipalComponents plain = principal_components(data, {.modes = 10});
    const PrincipalComponents permuted =
        principal_components(data(order, Eigen::all), {.modes = 10});
    EXPECT_LE((permuted.scores - plain.scores(order, Eigen::all)).cwiseAbs().maxCoeff(), 1e-10);
    EXPECT_LE((permuted.modes - plain.modes).cwiseAbs().maxCoeff(), 1e-10);
}

TEST(PrincipalComponents, KeepTheFewestModesThatReachTheShareOfTheVariance)
{
    for (const Index rows : {20, 90}) {
        const RowMatrix data = sample(rows, 100, 0.9, 11);
        const PrincipalComponents all = principal_components(data);
        ASSERT_EQ(all.variances.size(), rows - 1);
        for (const double share : {0.01, 0.5, 0.9, 0.99, 0.99999}) {
            const PrincipalComponents some = principal_components(data, {.variance = share});
            const Index count = some.variances.size();
            EXPECT_GE(some.variances.sum(), share * all.total_variance);
            EXPECT_LT(some.variances.head(count - 1).sum(), share * all.total_variance);
            EXPECT_LE((some.variances - all.variances.head(count)).cwiseAbs().maxCoeff(),
                      1e-13 * all.variances[0]);
            EXPECT_EQ(some.total_variance, all.total_variance);
        }
    }
}

TEST(PrincipalComponents, LeaveOutModesThatAreRounding)
{
    // 60 observations of rank 2.
    const Eigen::MatrixXd factors = test::random_matrix(60, 2, 12);
    const RowMatrix data = factors * test::random_matrix(2, 90, 13);
    for (const int modes : {0, 2, 10, 59}) {
        const PrincipalComponents result = principal_components(data, {.modes = modes});
        EXPECT_EQ(result.variances.size(), 2) << modes;
        expect_laws(data, result);
    }
}

TEST(PrincipalComponents, AreAsGoodForModesOfLittleVariance)
{
    // Standard deviations from 1 down to 3e-6.
    const RowMatrix data = sample(10, 200, 0.25, 14);
    const PrincipalComponents result = principal_components(data);
    EXPECT_LT(result.variances.tail(1)[0], 1e-9 * result.variances[0]);
    EXPECT_TRUE((result.modes * result.modes.transpose()).isIdentity(1e-13));
    const Eigen::JacobiSVD<Eigen::MatrixXd> svd(centred(data));
    for (Index k = 0; k < result.variances.size(); ++k) {
        const double variance = svd.singularValues()[k] * svd.singularValues()[k] / 9.0;
        EXPECT_NEAR(result.variances[k], variance, 1e-9 * variance);
    }
}

TEST(PrincipalComponents, HaveTheSameBitsForAnyThreadCount)
{
    const RowMatrix data = sample(230, 1200, 0.999, 15);
    const auto fitted = [&](int threads) {
        const test::ThreadScope scope(threads);
        return principal_components(data, {.modes = 12});
    };
    const PrincipalComponents one = fitted(1);
    for (const int threads : {2, 5}) {
        const PrincipalComponents many = fitted(threads);
        EXPECT_EQ(many.modes, one.modes);
        EXPECT_EQ(many.scores, one.scores);
        EXPECT_EQ(many.variances, one.variances);
        EXPECT_EQ(many.weights, one.weights);
    }
}

TEST(PrincipalComponents, RefuseWhatBreaksARule)
{
    const RowMatrix data = sample(5, 4, 0.9, 16);
    const double nan = std::numeric_limits<double>::quiet_NaN();
    EXPECT_THROW((void)principal_components(data.topRows(1)), InvalidInput);
    EXPECT_THROW((void)principal_components(RowMatrix(0, 4)), InvalidInput);
    EXPECT_THROW((void)principal_components(RowMatrix(4, 0)), InvalidInput);
    EXPECT_THROW((void)principal_components(data, {.modes = 5}), InvalidInput);
    EXPECT_THROW((void)principal_components(data, {.modes = -1}), InvalidInput);
    for (const double variance : {0.0, -0.5, 1.0 + 1e-12, nan})
        EXPECT_THROW((void)principal_components(data, {.variance = variance}), InvalidInput);
    RowMatrix broken = data;
    broken(3, 2) = nan;
    EXPECT_THROW((void)principal_components(broken), InvalidInput);
    EXPECT_NO_THROW((void)principal_components(data, {.modes = 4}));
}

TEST(PrincipalComponents, RefuseEqualObservations)
{
    const RowMatrix equal = sample(1, 30, 0.9, 17).replicate(8, 1);
    EXPECT_THROW((void)principal_components(equal), InvalidInput);
    // Equal but for rounding; and a difference well above it.
    const RowMatrix noise = test::random_matrix(8, 30, 18);
    EXPECT_THROW((void)principal_components(equal + 1e-15 * noise), InvalidInput);
    EXPECT_NO_THROW((void)principal_components(equal + 1e-9 * noise));
    EXPECT_THROW((void)principal_components(RowMatrix::Zero(3, 3)), InvalidInput);
}

TEST(CompanionModes, OfTheDataThemselvesAreTheModes)
{
    const RowMatrix data = sample(12, 30, 0.8, 19);
    const PrincipalComponents result = principal_components(data);
    EXPECT_LE((companion_modes(result, data) - result.modes).cwiseAbs().maxCoeff(), 1e-12);
}

TEST(CompanionModes, ReproduceTheCompanionWithTheScoresWhenAllModesAreKept)
{
    const RowMatrix data = sample(12, 30, 0.8, 20);
    const RowMatrix companion = test::random_matrix(12, 7, 21);
    const PrincipalComponents result = principal_components(data);
    const RowMatrix parts = companion_modes(result, companion);
    EXPECT_LE((result.scores * parts - centred(companion)).cwiseAbs().maxCoeff(), 1e-11);
}

TEST(CompanionModes, FollowALinearMapOfTheData)
{
    const RowMatrix data = sample(12, 30, 0.8, 22);
    const Eigen::MatrixXd map = test::random_matrix(30, 5, 23);
    const PrincipalComponents result = principal_components(data, {.modes = 4});
    EXPECT_LE((companion_modes(result, data * map) - result.modes * map).cwiseAbs().maxCoeff(),
              1e-12);
}

TEST(CompanionModes, RefuseAnotherNumberOfRows)
{
    const PrincipalComponents result = principal_components(sample(6, 5, 0.9, 24));
    EXPECT_THROW((void)companion_modes(result, RowMatrix::Zero(5, 5)), InvalidInput);
}

} // namespace
} // namespace shape
