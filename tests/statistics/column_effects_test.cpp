// SPDX-License-Identifier: MIT

#include "libshape/statistics/column_effects.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "libshape/base/error.h"
#include "tests/support/files.h"
#include "tests/support/matrices.h"

namespace shape {
namespace {

const RowMatrix first{{1.0, 10.0, -3.0}, {2.5, 9.0, -2.5}, {2.0, 14.0, -4.0}, {4.0, 11.5, -3.25}};
const RowMatrix second{{2.0, 9.5, -1.0}, {2.25, 12.0, -2.0}, {3.5, 8.0, -2.75},
                       {6.0, 9.0, -2.5}, {5.0, 7.5, 0.5},    {4.75, 10.0, -1.5}};

void expect_near(const Eigen::VectorXd& a, const Eigen::VectorXd& b, double tolerance)
{
    ASSERT_EQ(a.size(), b.size());
    EXPECT_LE((a - b).cwiseAbs().maxCoeff(), tolerance) << a.transpose() << "\n" << b.transpose();
}

/// How far the p of samples without a difference are from uniform (Kolmogorov and Smirnov).
double distance_from_uniform(Eigen::VectorXd p)
{
    std::sort(p.begin(), p.end());
    double distance = 0.0;
    const auto count = static_cast<double>(p.size());
    for (Eigen::Index i = 0; i < p.size(); ++i)
        distance = std::max({distance, static_cast<double>(i + 1) / count - p[i],
                             p[i] - static_cast<double>(i) / count});
    return distance;
}

TEST(PairedEffects, HaveTheirClosedFormForThreePairs)
{
    // Differences 1, 2, 3: mean 2, standard deviation 1, t = 2 sqrt(3) with 2 degrees of freedom.
    const ColumnEffects effects =
        paired_effects(RowMatrix{{5.0}, {5.0}, {5.0}}, RowMatrix{{6.0}, {7.0}, {8.0}});
    EXPECT_NEAR(effects.effects[0], 2.0, 1e-14);
    EXPECT_NEAR(effects.probabilities[0], 1.0 - 2.0 * std::sqrt(3.0) / std::sqrt(14.0), 1e-13);
}

// Expected values: tests/oracles/column_effects.py.
TEST(PairedEffects, AgreeWithScipy)
{
    const ColumnEffects effects = paired_effects(first, second.topRows(4));
    expect_near(effects.effects,
                Eigen::Vector3d(1.100406222605363, -0.3985266984930429, 1.700840128541522), 1e-14);
    expect_near(effects.probabilities,
                Eigen::Vector3d(0.1150845430158037, 0.483672190176139, 0.04240892676712452), 1e-12);
    expect_near(effects.false_discovery_rates, benjamini_hochberg(effects.probabilities), 0.0);
}

TEST(IndependentEffects, AgreeWithScipy)
{
    const ColumnEffects effects = independent_effects(first, second);
    expect_near(effects.effects,
                Eigen::Vector3d(1.041737017045719, -0.974883764957965, 1.623268633196727), 1e-14);
    expect_near(effects.probabilities,
                Eigen::Vector3d(0.1284385958256123, 0.2153316080837789, 0.02199466610022808),
                1e-12);
}

TEST(ColumnEffects, DoNotDependOnUnitsAndChangeSignWithTheOrder)
{
    for (unsigned seed = 1; seed <= 10; ++seed) {
        const RowMatrix a = test::random_matrix(7, 5, seed);
        const RowMatrix b = test::random_matrix(7, 5, 100 + seed);
        for (const auto& test : {paired_effects, independent_effects}) {
            const ColumnEffects once = test(a, b);
            const ColumnEffects scaled = test(1e3 * a, 1e3 * b);
            const ColumnEffects swapped = test(b, a);
            expect_near(scaled.effects, once.effects, 1e-12);
            expect_near(scaled.probabilities, once.probabilities, 1e-12);
            expect_near(swapped.effects, -once.effects, 1e-14);
            expect_near(swapped.probabilities, once.probabilities, 1e-14);
        }
    }
}

TEST(ColumnEffects, HaveUniformProbabilitiesWhereNothingDiffers)
{
    const double limit = 1.95 / std::sqrt(4000.0); // exceeded once in a thousand
    for (unsigned seed = 1; seed <= 3; ++seed) {
        const RowMatrix a = test::random_matrix(6, 4000, seed);
        const RowMatrix b = test::random_matrix(6, 4000, 10 + seed);
        const RowMatrix wide = 3.0 * test::random_matrix(12, 4000, 20 + seed);
        EXPECT_LE(distance_from_uniform(paired_effects(a, b).probabilities), limit);
        EXPECT_LE(distance_from_uniform(independent_effects(a, b).probabilities), 2.0 * limit);
        EXPECT_LE(distance_from_uniform(independent_effects(a, wide).probabilities), 2.0 * limit);
    }
}

TEST(ColumnEffects, OfAVariableThatNeverChangesIsNone)
{
    RowMatrix a = test::random_matrix(5, 3, 1);
    RowMatrix b = test::random_matrix(5, 3, 2);
    a.col(1).setConstant(0.7);
    b.col(1).setConstant(0.7);
    b(2, 1) += 1e-16;
    for (const auto& test : {paired_effects, independent_effects}) {
        const ColumnEffects effects = test(a, b);
        EXPECT_EQ(effects.effects[1], 0.0);
        EXPECT_EQ(effects.probabilities[1], 1.0);
        EXPECT_NE(effects.effects[2], 0.0);
    }
}

TEST(ColumnEffects, RefuseWhatHasNone)
{
    const RowMatrix good = test::random_matrix(4, 3, 1);
    RowMatrix infinite = good;
    infinite(1, 1) = std::numeric_limits<double>::infinity();
    for (const auto& test : {paired_effects, independent_effects}) {
        const auto message = [&](const RowMatrix& a, const RowMatrix& b) {
            return test::message_of<InvalidInput>([&] { (void)test(a, b); });
        };
        EXPECT_NE(message(good, good.topRows(1)).find("second has 1 observations"),
                  std::string::npos);
        EXPECT_NE(message(good.topRows(1), good).find("first has 1"), std::string::npos);
        EXPECT_NE(message(good.leftCols(2), good).find("variables"), std::string::npos);
        EXPECT_NE(message(good, infinite).find("finite"), std::string::npos);
        EXPECT_NE(message(RowMatrix::Constant(4, 3, 1.0), RowMatrix::Constant(4, 3, 2.0))
                      .find("variable 0"),
                  std::string::npos);
    }
    EXPECT_THROW((void)paired_effects(good, good.topRows(3)), InvalidInput);
}

TEST(BenjaminiHochberg, RejectsWhatThePaperDoes)
{
    // Benjamini and Hochberg 1995, section 3.2: at a rate of 0.05 the four smallest are rejected.
    Eigen::VectorXd p(15);
    p << 0.0001, 0.0004, 0.0019, 0.0095, 0.0201, 0.0278, 0.0298, 0.0344, 0.0459, 0.3240, 0.4262,
        0.5719, 0.6528, 0.7590, 1.000;
    const Eigen::VectorXd q = benjamini_hochberg(p);
    EXPECT_EQ((q.array() <= 0.05).count(), 4);
    EXPECT_NEAR(q[3], 0.0095 * 15.0 / 4.0, 1e-15);
    EXPECT_EQ(q[14], 1.0);
}

TEST(BenjaminiHochberg, IsItsDefinitionInAnyOrder)
{
    for (unsigned seed = 1; seed <= 10; ++seed) {
        const Eigen::VectorXd p = test::random_matrix(40, 1, seed).cwiseAbs().cwiseMin(1.0);
        const Eigen::VectorXd q = benjamini_hochberg(p);
        for (Eigen::Index i = 0; i < p.size(); ++i) {
            double least = 1.0; // over all thresholds that reject p_i
            for (const double threshold : p)
                if (threshold >= p[i])
                    least =
                        std::min(least, threshold * 40.0 /
                                            static_cast<double>((p.array() <= threshold).count()));
            EXPECT_NEAR(q[i], least, 1e-15);
        }
    }
}

TEST(BenjaminiHochberg, TakesNoneAndRefusesWhatIsNotAProbability)
{
    EXPECT_EQ(benjamini_hochberg(Eigen::VectorXd()).size(), 0);
    for (const double p : {-0.1, 1.1, std::nan("")})
        EXPECT_THROW((void)benjamini_hochberg(Eigen::VectorXd::Constant(2, p)), InvalidInput);
}

} // namespace
} // namespace shape
