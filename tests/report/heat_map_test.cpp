// SPDX-License-Identifier: MIT

#include "libshape/report/heat_map.h"

#include <gtest/gtest.h>

#include <set>

#include "libshape/base/error.h"
#include "libshape/base/to_size.h"
#include "libshape/report/svg.h"
#include "libshape/statistics/distance_matrix.h"
#include "tests/report/xml.h"
#include "tests/support/matrices.h"

namespace shape {
using namespace internal;
namespace {

HeatMap sample(int count)
{
    HeatMap map;
    for (int i = 0; i < count; ++i) {
        map.names.push_back("mesh<" + std::to_string(i));
        map.label_values.push_back(i % 3 == 0 ? "calm" : "glad");
    }
    map.distances = distance_matrix(test::random_matrix(count, 3, 1));
    map.clustering = cluster_by_average_linkage(map.distances);
    return map;
}

TEST(HeatMap, NamesTheRowsInTheOrderOfTheTree)
{
    const HeatMap map = sample(8);
    const auto elements = test::parse_xml(heat_map_svg(map));
    std::vector<std::string> found;
    for (const test::XmlElement& text : test::named(elements, "text"))
        if (text.text.starts_with("mesh<"))
            found.push_back(text.text);
    std::vector<std::string> expected;
    for (const int i : map.clustering.order)
        expected.push_back(map.names[to_size(i)]);
    EXPECT_EQ(found, expected);
    EXPECT_EQ(test::named(elements, "polyline").size(), 7U); // one a merge
    EXPECT_EQ(test::named(elements, "rect").size(), 11U);    // the ground, labels, their legend
}

TEST(HeatMap, LeavesOutNamesThatCouldNotBeRead)
{
    const auto elements = test::parse_xml(heat_map_svg(sample(100)));
    for (const test::XmlElement& text : test::named(elements, "text"))
        EXPECT_FALSE(text.text.starts_with("mesh<"));
}

TEST(HeatMap, HasALegendWithinTheDrawing)
{
    HeatMap map = sample(60);
    for (std::size_t i = 0; i < map.label_values.size(); ++i)
        map.label_values[i] = "subject " + std::to_string(i);
    const auto elements = test::parse_xml(heat_map_svg(map));
    const test::XmlElement ground = test::named(elements, "rect").front();
    std::set<std::string> columns;
    for (const test::XmlElement& text : test::named(elements, "text"))
        if (text.text.starts_with("subject")) {
            columns.insert(text.attributes.at("x"));
            EXPECT_LT(std::stod(text.attributes.at("x")) + text_width(text.text, 12.0),
                      std::stod(ground.attributes.at("width")));
            EXPECT_LT(std::stod(text.attributes.at("y")),
                      std::stod(ground.attributes.at("height")));
        }
    EXPECT_GT(columns.size(), 1U);
}

TEST(HeatMap, OfEqualThingsAndOfOneIsDrawnToo)
{
    HeatMap map{
        .title = "one", .names = {"a"}, .label_values = {}, .distances = {}, .clustering = {}};
    map.distances = Eigen::MatrixXd::Zero(1, 1);
    map.clustering = cluster_by_average_linkage(map.distances);
    EXPECT_NO_THROW((void)test::parse_xml(heat_map_svg(map)));
    map.names = {"a", "b"};
    map.distances = Eigen::MatrixXd::Zero(2, 2);
    map.clustering = cluster_by_average_linkage(map.distances);
    EXPECT_EQ(heat_map_svg(map).find("nan"), std::string::npos);
}

TEST(HeatMap, RefusesWhatDoesNotFit)
{
    HeatMap map = sample(4);
    map.names.pop_back();
    EXPECT_THROW((void)heat_map_svg(map), InvalidInput);
    map = sample(4);
    map.label_values.pop_back();
    EXPECT_THROW((void)heat_map_svg(map), InvalidInput);
    map = sample(4);
    map.clustering = sample(5).clustering;
    EXPECT_THROW((void)heat_map_svg(map), InvalidInput);
    EXPECT_THROW((void)heat_map_svg({}), InvalidInput);
}

} // namespace
} // namespace shape
