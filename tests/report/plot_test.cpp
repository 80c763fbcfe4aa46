// SPDX-License-Identifier: MIT

#include "libshape/report/plot.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <set>

#include "libshape/base/error.h"
#include "libshape/base/random.h"
#include "tests/report/xml.h"

namespace shape {
using namespace internal;
namespace {

TEST(RoundTicks, CoverTheDataInEvenRoundSteps)
{
    Random random(5);
    for (int trial = 0; trial < 2000; ++trial) {
        const double scale = std::pow(10.0, random.uniform(-9.0, 9.0));
        const double low = scale * random.normal();
        const double high = low + scale * random.uniform(1e-3, 10.0);
        const std::vector<double> ticks = round_ticks(low, high);
        ASSERT_GE(ticks.size(), 3U);
        ASSERT_LE(ticks.size(), 14U);
        const double step = ticks[1] - ticks[0];
        EXPECT_LE(ticks.front(), low);
        EXPECT_GE(ticks.back(), high);
        EXPECT_GT(ticks.front() + 1.000001 * step, low);
        EXPECT_LT(ticks.back() - 1.000001 * step, high);
        const double leading = step / std::pow(10.0, std::floor(std::log10(step) + 1e-9));
        EXPECT_TRUE(std::abs(leading - 1.0) < 1e-6 || std::abs(leading - 2.0) < 1e-6 ||
                    std::abs(leading - 5.0) < 1e-6)
            << step;
    }
    EXPECT_EQ(round_ticks(0.0, 10.0), (std::vector<double>{0, 2, 4, 6, 8, 10}));
    EXPECT_LT(round_ticks(3.0, 3.0).front(), 3.0);
    EXPECT_LT(round_ticks(1e12, 1e12 + 1e-4).size(), 20U);
    EXPECT_GT(round_ticks(0.0, 0.0).back(), 0.0);
}

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
                                 Eigen::Vector3d(0.4567, 0.3, 0.1), 1, 0);
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
    Plot plot;
    plot.series.push_back({"s", Eigen::MatrixX2d::Zero(2, 2), {"one"}, false});
    EXPECT_THROW((void)plot_svg(plot), InvalidInput);
}

TEST(PlotSvg, IsWellFormedAndShowsEveryPointTickAndName)
{
    const Plot plot = score_plot(four_scores(), four_names, {"<x>", "y", "<x>", "y"}, {});
    const std::vector<test::XmlElement> elements = test::parse_xml(plot_svg(plot));
    EXPECT_EQ(test::named(elements, "path").size(), 4U + 2U); // points and legend
    std::vector<std::string> tips;
    for (const test::XmlElement& title : test::named(elements, "title"))
        tips.push_back(title.text);
    EXPECT_EQ(tips, (std::vector<std::string>{"a", "c&", "b<", "d"}));
    std::vector<std::string> texts;
    for (const test::XmlElement& text : test::named(elements, "text"))
        texts.push_back(text.text);
    for (const char* wanted : {"<x>", "y", "mode 1", "mode 2", "0.0", "\u22121.0"})
        EXPECT_NE(std::find(texts.begin(), texts.end(), wanted), texts.end())
            << wanted << " is not among " << ::testing::PrintToString(texts);
    EXPECT_EQ(plot_svg(plot), plot_svg(plot));
}

TEST(PlotSvg, HasALegendWithinThePlot)
{
    Plot plot;
    for (int i = 0; i < 40; ++i)
        plot.series.push_back(
            {"subject " + std::to_string(i), Eigen::MatrixX2d::Random(3, 2), {}, i % 2 == 0});
    const std::vector<test::XmlElement> elements = test::parse_xml(plot_svg(plot, 500, 400));
    const double top = std::stod(test::named(elements, "line").front().attributes.at("y2"));
    std::set<std::string> rows;
    for (const test::XmlElement& text : test::named(elements, "text"))
        if (text.text.starts_with("subject")) {
            rows.insert(text.attributes.at("y"));
            EXPECT_LT(std::stod(text.attributes.at("x")) + text_width(text.text, 12.0), 500.0);
            EXPECT_GT(std::stod(text.attributes.at("y")), 8.0);
            EXPECT_LT(std::stod(text.attributes.at("y")), top);
        }
    EXPECT_EQ(rows.size(), 10U);
}

TEST(PlotSvg, WastesNoRoomBesideTheData)
{
    Plot plot;
    plot.series.push_back({"", Eigen::MatrixX2d(2, 2), {}, true});
    plot.series[0].points << -0.00105, 1.0, 0.00087, 1.0; // the second coordinates are equal
    const std::vector<test::XmlElement> elements = test::parse_xml(plot_svg(plot, 500, 400));
    double x0, y0, x1, y1;
    const std::string line = test::named(elements, "polyline").at(0).attributes.at("points");
    ASSERT_EQ(std::sscanf(line.c_str(), "%lf,%lf %lf,%lf", &x0, &y0, &x1, &y1), 4);
    EXPECT_GT(x1 - x0, 0.9 * (500 - 88));
    EXPECT_EQ(y0, y1);
    for (const test::XmlElement& grid : test::named(elements, "line")) {
        EXPECT_GE(std::stod(grid.attributes.at("x1")), 70.0);
        EXPECT_LE(std::stod(grid.attributes.at("x2")), 482.0);
    }
}

TEST(PlotSvg, LeavesOutPointsThatAreNotFinite)
{
    Plot plot;
    plot.series.push_back({"s", Eigen::MatrixX2d::Zero(3, 2), {}, false});
    plot.series[0].points(1, 0) = std::numeric_limits<double>::quiet_NaN();
    EXPECT_EQ(test::named(test::parse_xml(plot_svg(plot)), "path").size(), 2U);
    plot.series[0].points.setConstant(std::numeric_limits<double>::infinity());
    EXPECT_EQ(test::named(test::parse_xml(plot_svg(plot)), "path").size(), 0U);
}

TEST(PlotSvg, PutsPointsWhereTheTicksSay)
{
    // The extreme points lie on the outer grid lines, the middle one half-way.
    Plot plot;
    plot.series.push_back({"", Eigen::MatrixX2d(3, 2), {}, true});
    plot.series[0].points << 0, 0, 5, 5, 10, 10;
    const std::vector<test::XmlElement> elements = test::parse_xml(plot_svg(plot, 500, 400));
    double x0, y0, x1, y1, x2, y2;
    const std::string line = test::named(elements, "polyline").at(0).attributes.at("points");
    ASSERT_EQ(std::sscanf(line.c_str(), "%lf,%lf %lf,%lf %lf,%lf", &x0, &y0, &x1, &y1, &x2, &y2),
              6);
    EXPECT_NEAR(x1, 0.5 * (x0 + x2), 0.02);
    EXPECT_NEAR(y1, 0.5 * (y0 + y2), 0.02);
    EXPECT_LT(x0, x2);
    EXPECT_GT(y0, y2);
    const auto lines = test::named(elements, "line");
    EXPECT_NEAR(std::stod(lines.front().attributes.at("x1")), x0, 0.02);
    plot.equal_axes = true;
    const std::string equal = test::named(test::parse_xml(plot_svg(plot, 500, 400)), "polyline")
                                  .at(0)
                                  .attributes.at("points");
    ASSERT_EQ(std::sscanf(equal.c_str(), "%lf,%lf %lf,%lf %lf,%lf", &x0, &y0, &x1, &y1, &x2, &y2),
              6);
    EXPECT_NEAR(x2 - x0, y0 - y2, 0.05);
}

} // namespace
} // namespace shape
