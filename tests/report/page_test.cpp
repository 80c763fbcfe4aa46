// SPDX-License-Identifier: MIT

#include "libshape/report/page.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "libshape/base/error.h"
#include "libshape/report/base64.h"
#include "libshape/report/plot.h"
#include "tests/report/xml.h"
#include "tests/support/meshes.h"

namespace shape {
using namespace internal;
namespace {

Page sample()
{
    const test::TestMesh mesh = test::bumpy_sphere(1, 0.2, 1);
    Page page{.title = "A <model> & more",
              .facts = {{"Meshes", "7"}, {"File", "<a>.h5"}},
              .faces = mesh.topology.faces(),
              .tracks = {{"mode 1", {mesh.points, 2.0 * mesh.points}, -2.0, 2.0},
                         {"mode <2>", {mesh.points}, 0.5, 0.5}},
              .unit = "standard deviations",
              .drawings = {},
              .table = {{"Mode", "Variance"}, {"1", "0.5"}, {"2", "<0.1"}}};
    Plot plot;
    plot.series.push_back({"", Eigen::MatrixX2d::Identity(2, 2), {}, true});
    page.drawings.push_back(plot_svg(plot));
    return page;
}

/// The document without what is not XML, and what stood in the first such element.
std::pair<std::string, std::string> without(std::string html, const std::string& from,
                                            const std::string& to)
{
    const std::size_t begin = html.find(from);
    const std::size_t end = html.find(to, begin);
    const std::string inside = html.substr(begin + from.size(), end - begin - from.size());
    return {html.erase(begin, end + to.size() - begin), inside};
}

std::vector<test::XmlElement> elements_of(const std::string& html)
{
    std::string text = without(html, "<!DOCTYPE", ">\n").first;
    text = without(text, "<style>", "</style>").first;
    text = without(text, "<script>", "</script>").first;
    return test::parse_xml(text);
}

std::vector<std::string> texts(const std::vector<test::XmlElement>& elements,
                               const std::string& name)
{
    std::vector<std::string> found;
    for (const test::XmlElement& element : test::named(elements, name))
        found.push_back(element.text);
    return found;
}

TEST(PageHtml, HoldsAllThatIsOnThePage)
{
    const std::string html = page_html(sample());
    const auto elements = elements_of(html);
    EXPECT_EQ(texts(elements, "h1"), (std::vector<std::string>{"A <model> & more"}));
    EXPECT_EQ(texts(elements, "dt"), (std::vector<std::string>{"Meshes", "File"}));
    EXPECT_EQ(texts(elements, "dd"), (std::vector<std::string>{"7", "<a>.h5"}));
    EXPECT_EQ(texts(elements, "option"), (std::vector<std::string>{"mode 1", "mode <2>"}));
    EXPECT_EQ(texts(elements, "th"), (std::vector<std::string>{"Mode", "Variance"}));
    EXPECT_EQ(texts(elements, "td"), (std::vector<std::string>{"1", "0.5", "2", "<0.1"}));
    EXPECT_EQ(test::named(elements, "svg").size(), 1U);
    EXPECT_EQ(html, page_html(sample()));
}

TEST(PageHtml, NeedsNoOtherFile)
{
    const std::string html = page_html(sample());
    for (const char* sign : {"src=", "@import", "url(", "fetch(", "<link"})
        EXPECT_EQ(html.find(sign), std::string::npos) << sign;
    for (const test::XmlElement& element : elements_of(html))
        EXPECT_EQ(element.attributes.count("href"), 0U);
}

TEST(PageHtml, CarriesTheShapesInABallOfRadiusOne)
{
    const Page page = sample();
    const auto [rest, text] =
        without(page_html(page), "<script type=\"application/json\" id=\"shapes\">", "</script>");
    const nlohmann::json data = nlohmann::json::parse(text);
    ASSERT_EQ(data["tracks"].size(), 2U);
    EXPECT_EQ(data["tracks"][0]["low"], -2.0);
    EXPECT_EQ(data["tracks"][0]["high"], 2.0);
    ASSERT_EQ(data["tracks"][0]["shapes"].size(), 2U);
    EXPECT_EQ(data["tracks"][1]["shapes"][0], data["tracks"][0]["shapes"][0]);
    // The same bytes, made from what they must be: the larger shape fills the ball's box.
    const Points& large = page.tracks[0].shapes[1];
    const Eigen::RowVector3d low = large.colwise().minCoeff();
    const Eigen::RowVector3d high = large.colwise().maxCoeff();
    for (std::size_t i = 0; i < 2; ++i) {
        const Eigen::Matrix<float, Eigen::Dynamic, 3, Eigen::RowMajor> moved =
            ((page.tracks[0].shapes[i].rowwise() - 0.5 * (low + high)) /
             (0.5 * (high - low).norm()))
                .cast<float>();
        EXPECT_LE(moved.rowwise().norm().maxCoeff(), 1.0F);
        EXPECT_EQ(data["tracks"][0]["shapes"][i],
                  base64({reinterpret_cast<const char*>(moved.data()),
                          static_cast<std::size_t>(moved.size()) * sizeof(float)}));
    }
    const Eigen::Matrix<int, Eigen::Dynamic, 3, Eigen::RowMajor> faces = page.faces;
    EXPECT_EQ(data["faces"], base64({reinterpret_cast<const char*>(faces.data()),
                                     static_cast<std::size_t>(faces.size()) * sizeof(int)}));
}

TEST(PageHtml, HasNoViewerWithoutShapes)
{
    Page page = sample();
    page.tracks.clear();
    const std::string html = page_html(page);
    EXPECT_EQ(html.find("<script"), std::string::npos);
    EXPECT_EQ(html.find("<canvas"), std::string::npos);
}

TEST(PageHtml, RefusesShapesThatDoNotFitEachOther)
{
    Page page = sample();
    page.tracks[1].shapes.clear();
    EXPECT_THROW((void)page_html(page), InvalidInput);
    page = sample();
    page.tracks[1].shapes[0] = page.tracks[0].shapes[0].topRows(5);
    EXPECT_THROW((void)page_html(page), InvalidInput);
    page = sample();
    page.tracks[0].shapes[1](0, 0) = std::numeric_limits<double>::quiet_NaN();
    EXPECT_THROW((void)page_html(page), InvalidInput);
}

} // namespace
} // namespace shape
