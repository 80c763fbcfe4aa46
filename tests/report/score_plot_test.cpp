// SPDX-License-Identifier: MIT

#include "libshape/report/score_plot.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/random.h"
#include "libshape/base/to_size.h"
#include "libshape/report/colour_map.h"

namespace shape {
using namespace internal;
namespace {

RowMatrix four_scores()
{
    RowMatrix scores(4, 3);
    scores << 1, 2, 9, -1, 0.5, 9, 0, -2, 9, 0.25, 0.25, 9;
    return scores;
}

const std::vector<std::string> four_names{"a", "b<", "c&", "d"};

TEST(ScorePlot, GroupsByLabelInTheOrderOfAppearance)
{
    const Plot plot = score_plot(four_scores(), four_names, {"x", "y", "x", "y"},
                                 Eigen::Vector3d(0.4567, 0.3, 0.1), {.mode_x = 1, .mode_y = 0});
    ASSERT_EQ(plot.series.size(), 2U);
    EXPECT_EQ(plot.series[0].name, "x");
    EXPECT_EQ(plot.series[0].tips, (std::vector<std::string>{"a", "c&"}));
    EXPECT_EQ(plot.series[1].points.row(0), Eigen::RowVector2d(0.5, -1.0));
    EXPECT_EQ(plot.y_label, "mode 1 (45.7 % of variance)");
    EXPECT_EQ(plot.x_label, "mode 2 (30 % of variance)");
}

TEST(ScorePlot, RefusesSizesThatDoNotFit)
{
    EXPECT_THROW((void)score_plot(four_scores(), {"a"}, {}, {}), InvalidInput);
    EXPECT_THROW((void)score_plot(four_scores(), four_names, {"x"}, {}), InvalidInput);
    EXPECT_THROW((void)score_plot(four_scores(), four_names, {}, {}, {.mode_x = 0, .mode_y = 3}),
                 InvalidInput);
    EXPECT_THROW((void)score_plot(four_scores(), four_names, {}, {}, {.mode_x = -1, .mode_y = 0}),
                 InvalidInput);
}

struct Meshes
{
    RowMatrix scores;
    std::vector<std::string> names;
};

Meshes meshes(Eigen::Index count)
{
    Random random(7);
    Meshes made{RowMatrix(count, 2), {}};
    for (Eigen::Index i = 0; i < count; ++i) {
        made.scores.row(i) << random.normal(), 3.0 * random.normal();
        made.names.push_back(join("m", i));
    }
    return made;
}

TEST(ScorePlot, NumbersStandOnAScaleAndFewOfThemAreCategories)
{
    const Meshes all = meshes(9);
    const std::vector<std::string> ages{"20", "31.5", "-4", "50", "1e2", "7", "", "8", "9"};
    const Plot plot = score_plot(all.scores, all.names, ages, {}, {.label_name = "age"});
    ASSERT_EQ(plot.series.size(), 1U);
    EXPECT_EQ(plot.scale_label, "age");
    ASSERT_EQ(plot.series[0].values.size(), 9);
    EXPECT_EQ(plot.series[0].values[4], 100.0);
    EXPECT_TRUE(std::isnan(plot.series[0].values[6]));
    EXPECT_EQ(plot.series[0].tips, all.names);
    const std::vector<std::string> visits{"1", "2", "3", "1", "2", "3", "4", "5", "6"};
    EXPECT_EQ(score_plot(all.scores, all.names, visits, {}).series.size(), 6U);
    std::vector<std::string> words = ages;
    words[0] = "old";
    EXPECT_EQ(score_plot(all.scores, all.names, words, {}).series.size(), 9U);
}

TEST(ScorePlot, ManyCategoriesFoldAndThoseWithoutAValueStayApart)
{
    // Value k occurs k + 1 times, of 20; the first two meshes have none.
    std::vector<std::string> values{"", ""};
    for (int k = 0; k < 20; ++k)
        values.insert(values.end(), to_size(k + 1), join("g", k));
    const Meshes all = meshes(static_cast<Eigen::Index>(values.size()));
    const Plot plot = score_plot(all.scores, all.names, values, {});
    ASSERT_EQ(plot.series.size(), most_plot_groups + 1);
    EXPECT_EQ(plot.series[0].name, "no value");
    EXPECT_EQ(plot.series[0].tips, (std::vector<std::string>{"m0", "m1"}));
    for (std::size_t s = 1; s < most_plot_groups; ++s) {
        EXPECT_EQ(plot.series[s].name, join("g", s + 8));
        EXPECT_FALSE(plot.series[s].colour);
    }
    EXPECT_EQ(plot.series.back().name, "9 others");
    EXPECT_EQ(plot.series.back().points.rows(), 45);
    EXPECT_EQ(plot.series.back().tips.front(), "m2 (g0)");
    ASSERT_TRUE(plot.series.back().colour);
    EXPECT_EQ(plot.series.back().colour->red, plot.series.back().colour->blue);
    Eigen::Index points = 0;
    for (const Series& series : plot.series)
        points += series.points.rows();
    EXPECT_EQ(points, all.scores.rows());
    // Of equally large ones the first stay; twelve need no folding.
    for (const std::size_t count : {most_plot_groups, most_plot_groups + 5}) {
        std::vector<std::string> equal;
        for (std::size_t i = 0; i < count; ++i)
            equal.push_back(join("e", i));
        const Meshes few = meshes(static_cast<Eigen::Index>(count));
        const Plot folded = score_plot(few.scores, few.names, equal, {});
        EXPECT_EQ(folded.series.size(), most_plot_groups);
        EXPECT_EQ(folded.series[10].name, "e10");
        EXPECT_EQ(folded.series[11].name, count == most_plot_groups ? "e11" : "6 others");
    }
}

TEST(ScorePlot, HullsHoldTheirPointsAndTurnOneWay)
{
    const Meshes all = meshes(60);
    std::vector<std::string> values;
    for (int i = 0; i < 60; ++i)
        values.emplace_back(i < 2 ? "pair" : i % 2 == 0 ? "a" : "b");
    const Plot plot =
        score_plot(all.scores, all.names, values, {}, {.outline = GroupOutline::Hull});
    ASSERT_EQ(plot.series.size(), 5U); // no hull of two points
    for (std::size_t s = 3; s < 5; ++s) {
        const Eigen::MatrixX2d& corners = plot.series[s].points;
        EXPECT_TRUE(plot.series[s].curve);
        EXPECT_EQ(plot.series[s].name, "");
        EXPECT_EQ(plot.series[s].colour->red, category_colour(s - 2).red);
        EXPECT_EQ(corners.row(0), corners.row(corners.rows() - 1));
        const Eigen::MatrixX2d& points = plot.series[s - 2].points;
        for (Eigen::Index i = 0; i + 1 < corners.rows(); ++i) {
            const Eigen::RowVector2d side = corners.row(i + 1) - corners.row(i);
            bool is_point = false;
            for (const auto& point : points.rowwise()) {
                const Eigen::RowVector2d to = point - corners.row(i);
                EXPECT_GE(side.x() * to.y() - side.y() * to.x(), -1e-12);
                is_point = is_point || to.norm() == 0.0;
            }
            EXPECT_TRUE(is_point);
        }
    }
}

TEST(ScorePlot, EllipsesHoldNinetyFivePercentOfANormalDistribution)
{
    const Meshes all = meshes(20000);
    const std::vector<std::string> values(20000, "a");
    const Plot plot =
        score_plot(all.scores, all.names, values, {}, {.outline = GroupOutline::Ellipse});
    ASSERT_EQ(plot.series.size(), 2U);
    const Eigen::MatrixX2d& curve = plot.series[1].points;
    // Its axes are those of the distribution: standard deviations 1 and 3, chi-square 5.991.
    EXPECT_NEAR(curve.col(0).maxCoeff(), std::sqrt(5.991), 0.05);
    EXPECT_NEAR(curve.col(1).maxCoeff(), 3.0 * std::sqrt(5.991), 0.15);
    int inside = 0;
    for (const auto& point : all.scores.rowwise())
        inside += point[0] * point[0] + point[1] * point[1] / 9.0 <= 5.991;
    EXPECT_NEAR(inside / 20000.0, 0.95, 0.005);
}

} // namespace
} // namespace shape
