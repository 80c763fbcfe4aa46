// SPDX-License-Identifier: MIT

#include "libshape/statistics/streamed_sums.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "libshape/base/to_size.h"
#include "libshape/statistics/inner_products.h"
#include "tests/support/matrices.h"
#include "tests/support/thread_scope.h"

namespace shape::internal {
namespace {

using Eigen::Index;

/// Weights that depend on member, column and point in a way without a pattern.
double weight(Index member, std::size_t set, int point, Index column)
{
    return std::sin(1.0 + 3.7 * static_cast<double>(member) + 11.3 * static_cast<double>(set) +
                    0.9 * point + 5.1 * static_cast<double>(column));
}

SumFamily family(Index members, std::vector<SumColumns> columns)
{
    SumFamily result{members, columns, {}, 1000};
    result.prepare = [columns](Index begin, Index end) -> SumFamily::Fill {
        return
            [columns, begin, end](Index member, std::size_t set, std::size_t first, Block weights) {
                EXPECT_GE(member, begin);
                EXPECT_LT(member, end);
                for (Index i = 0; i < weights.rows(); ++i)
                    for (Index j = 0; j < weights.cols(); ++j)
                        weights(i, j) =
                            weight(member, set, columns[set].support[first + to_size(i)], j);
            };
    };
    return result;
}

/// 40 points in parts that lie scattered, of sizes 1 to several, and some points in none.
SumQuestions questions()
{
    std::vector<int> all(40), few{3, 4, 17, 21, 38};
    PartSums parts{{}, {}, {}, 12};
    for (int i = 0; i < 40; ++i) {
        all[to_size(i)] = i;
        if (i % 9 == 4)
            continue;
        parts.points.push_back(i);
        parts.part_of.push_back(i < 10 ? i : 10 + i % 2);
    }
    parts.weights = Eigen::VectorXd::LinSpaced(static_cast<Index>(parts.points.size()), -1.0, 2.0);
    PartSums from_references = parts;
    from_references.taken = test::random_matrix(12, 2, 5);
    return {{family(700, {{1, all}}), family(3, {{2, few}, {1, all}})},
            {parts, from_references},
            group_by({"a", "b", "b", "c", "a", "a", "a", "a", "a", "a", "a", "a", "a", "a",
                      "a", "a", "a", "a", "a", "a", "b", "b", "b", "b", "b", "b", "b", "b",
                      "b", "b", "b", "b", "b", "b", "b", "b", "b", "b", "b", "b"}),
            test::random_matrix(40, 2, 6)};
}

/// From passes in tiles of 7; counts them.
SumAnswers in_passes(const RowMatrix& points, const SumQuestions& asked, std::uint64_t memory,
                     int& passes)
{
    RowMatrix means(0, points.cols());
    if (asked.groups) {
        const Eigen::MatrixXd inside = indicators(*asked.groups);
        means = inside.colwise().sum().cwiseInverse().asDiagonal() * inside.transpose() * points;
    }
    const auto pass = [&](const PointPasses::Visit& visit) {
        ++passes;
        for (Index first = 0; first < points.rows(); first += 7)
            visit(first, points.middleRows(first, std::min<Index>(7, points.rows() - first)));
    };
    const RowMatrix references = asked.references.transpose() * points;
    return answer({points.rows(), points.cols(), pass, means, references}, asked, memory);
}

void expect_near(const SumAnswers& a, const SumAnswers& b, double tolerance)
{
    EXPECT_LE((a.squares - b.squares).cwiseAbs().maxCoeff(), tolerance);
    ASSERT_EQ(a.squares_about_means.size(), b.squares_about_means.size());
    EXPECT_LE((a.squares_about_means - b.squares_about_means).norm(), tolerance);
    ASSERT_EQ(a.families.size(), b.families.size());
    for (std::size_t f = 0; f < a.families.size(); ++f) {
        ASSERT_EQ(a.families[f].size(), b.families[f].size());
        for (std::size_t m = 0; m < a.families[f].size(); ++m)
            EXPECT_LE((a.families[f][m] - b.families[f][m]).cwiseAbs().maxCoeff(), tolerance)
                << f << " " << m;
    }
    ASSERT_EQ(a.parts.size(), b.parts.size());
    for (std::size_t p = 0; p < a.parts.size(); ++p)
        EXPECT_LE((a.parts[p] - b.parts[p]).cwiseAbs().maxCoeff(), tolerance);
}

TEST(StreamedSums, AreThoseThatAllInnerProductsGive)
{
    const RowMatrix points = test::random_matrix(40, 30, 1);
    const SumQuestions asked = questions();
    int passes = 0;
    const SumAnswers sums = in_passes(points, asked, 1 << 30, passes);
    EXPECT_EQ(passes, 1);
    expect_near(sums, answer(inner_products(points), asked), 1e-10);
}

TEST(StreamedSums, HaveTheSameBitsForAnyMemoryAndThreadCount)
{
    const RowMatrix points = test::random_matrix(40, 30, 2);
    const SumQuestions asked = questions();
    int few = 0;
    const SumAnswers expected = in_passes(points, asked, 1 << 30, few);
    for (const std::uint64_t memory : {1U, 5000U, 400000U}) {
        int passes = 0;
        const test::ThreadScope scope(memory == 5000U ? 1 : 3);
        expect_near(in_passes(points, asked, memory, passes), expected, 0.0);
        EXPECT_GT(passes, 1);
    }
}

TEST(StreamedSums, OfPointsInMemoryAreTheSame)
{
    const RowMatrix points = test::random_matrix(40, 1, 3);
    SumQuestions asked = questions();
    asked.groups.reset();
    SumAnswers expected = answer(inner_products(points), asked);
    expect_near(answer_in_memory(points, asked), expected, 1e-11);
}

TEST(StreamedSums, OfPartsAreMeasuredFromReferences)
{
    const RowMatrix points = test::random_matrix(5, 4, 4);
    PartSums parts{{0, 1, 3}, {0, 0, 1}, Eigen::Vector3d(0.5, 0.5, 1.0), 2};
    parts.taken = (Eigen::MatrixXd(2, 2) << 1.0, -2.0, 0.0, 3.0).finished();
    Eigen::MatrixXd references = Eigen::MatrixXd::Zero(5, 2);
    references(4, 0) = 1.0;
    references.col(1).setConstant(0.2);
    const SumQuestions asked{{}, {parts}, {}, references};
    const Eigen::RowVectorXd mean = points.colwise().mean();
    const Eigen::RowVectorXd first =
        0.5 * (points.row(0) + points.row(1)) - points.row(4) + 2.0 * mean;
    for (const SumAnswers& found :
         {answer_in_memory(points, asked), answer(inner_products(points), asked)}) {
        EXPECT_NEAR(found.parts[0][0], first.squaredNorm(), 1e-12);
        EXPECT_NEAR(found.parts[0][1], (points.row(3) - 3.0 * mean).squaredNorm(), 1e-12);
    }
}

TEST(StreamedSums, OfNoPointAreZero)
{
    const RowMatrix points = test::random_matrix(5, 4, 4);
    const SumAnswers found =
        answer_in_memory(points, {{}, {{{1, 3}, {0, 0}, Eigen::Vector2d(1.0, -1.0), 3}}, {}});
    EXPECT_NEAR(found.parts[0][0], (points.row(1) - points.row(3)).squaredNorm(), 1e-13);
    EXPECT_EQ(found.parts[0][1], 0.0);
    EXPECT_EQ(found.parts[0][2], 0.0);
}

} // namespace
} // namespace shape::internal
