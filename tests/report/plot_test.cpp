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

TEST(PlotSvg, RefusesWhatIsNotOneAPoint)
{
    Plot plot;
    plot.series.push_back({"s", Eigen::MatrixX2d::Zero(2, 2), {"one"}, false});
    EXPECT_THROW((void)plot_svg(plot), InvalidInput);
    plot.series[0].tips.clear();
    plot.series[0].values = Eigen::Vector3d::Zero();
    EXPECT_THROW((void)plot_svg(plot), InvalidInput);
    plot.series[0].values = {};
    plot.series[0].deviations = Eigen::Vector3d::Zero();
    EXPECT_THROW((void)plot_svg(plot), InvalidInput);
    plot.series[0].deviations = {};
    EXPECT_NO_THROW((void)plot_svg(plot));
}

TEST(PlotSvg, IsWellFormedAndShowsEveryPointTickAndName)
{
    Plot plot;
    plot.x_label = "mode 1";
    plot.y_label = "mode 2";
    plot.series = {{"<x>", Eigen::MatrixX2d(2, 2), {"a", "c&"}, false},
                   {"y", Eigen::MatrixX2d(2, 2), {"b<", "d"}, false}};
    plot.series[0].points << 1, 2, 0, -2;
    plot.series[1].points << -1, 0.5, 0.25, 0.25;
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

TEST(PlotSvg, DrawsDeviationsAsBarsAndMakesRoomForThem)
{
    Plot plot;
    plot.series.push_back({"", Eigen::MatrixX2d(2, 2), {}, true});
    plot.series[0].points << 0, 5, 10, 5;
    const std::size_t bare = test::named(test::parse_xml(plot_svg(plot, 500, 400)), "line").size();
    plot.series[0].deviations = Eigen::Vector2d(5.0, 0.0);
    const auto lines = test::named(test::parse_xml(plot_svg(plot, 500, 400)), "line");
    std::size_t bars = 0;
    double length = 0.0;
    for (const test::XmlElement& line : lines)
        if (line.attributes.at("stroke") == "#0072b2") {
            ++bars;
            length = std::max(length, std::abs(std::stod(line.attributes.at("y1")) -
                                               std::stod(line.attributes.at("y2"))));
        }
    EXPECT_EQ(bars, 3U);      // one bar with two ends: a deviation of 0 needs none
    EXPECT_GT(length, 250.0); // from 0 to 10, which is all there is
    EXPECT_GE(lines.size(), bare);
}

TEST(PlotSvg, ColoursValuesByAScaleThatStandsBesideThePlot)
{
    Plot plot;
    plot.scale_label = "age";
    plot.series.push_back({"", Eigen::MatrixX2d(3, 2), {}, false});
    plot.series[0].points << 0, 0, 1, 1, 2, 2;
    plot.series[0].values = Eigen::Vector3d(20.0, std::numeric_limits<double>::quiet_NaN(), 80.0);
    const auto elements = test::parse_xml(plot_svg(plot, 500, 400));
    std::vector<std::string> fills;
    for (const test::XmlElement& mark : test::named(elements, "path"))
        fills.push_back(mark.attributes.at("fill"));
    ASSERT_EQ(fills.size(), 3U);
    EXPECT_NE(fills[0], fills[2]);
    EXPECT_EQ(fills[1], "#808080");
    std::set<std::string> steps;
    for (const test::XmlElement& step : test::named(elements, "rect"))
        steps.insert(step.attributes.at("fill"));
    EXPECT_GT(steps.size(), 50U);
    std::set<std::string> texts;
    for (const test::XmlElement& text : test::named(elements, "text"))
        texts.insert(text.text);
    for (const char* said : {"age", "20", "40", "60", "80"})
        EXPECT_TRUE(texts.contains(said)) << said;
}

TEST(PlotSvg, WritesNamesWhereTheyCoverNothing)
{
    Plot plot;
    plot.point_names = true;
    plot.series.push_back({"", Eigen::MatrixX2d(40, 2), {}, false});
    for (int i = 0; i < 40; ++i) {
        plot.series[0].points.row(i) << (i < 4 ? i : 4.0), (i < 4 ? i * i : 16.0);
        plot.series[0].tips.push_back("mesh" + std::to_string(i));
    }
    struct Written
    {
        double left, right, base;
    };
    std::vector<Written> written;
    for (const test::XmlElement& text :
         test::named(test::parse_xml(plot_svg(plot, 500, 400)), "text"))
        if (text.text.starts_with("mesh")) {
            const double x = std::stod(text.attributes.at("x"));
            written.push_back(
                {x, x + text_width(text.text, 10.0), std::stod(text.attributes.at("y"))});
        }
    EXPECT_GE(written.size(), 5U); // the four that stand alone, and few of the heap
    EXPECT_LE(written.size(), 8U);
    for (std::size_t i = 0; i < written.size(); ++i)
        for (std::size_t j = 0; j < i; ++j)
            EXPECT_TRUE(written[i].right <= written[j].left ||
                        written[j].right <= written[i].left ||
                        std::abs(written[i].base - written[j].base) >= 10.0)
                << i << " covers " << j;
}

} // namespace
} // namespace shape
