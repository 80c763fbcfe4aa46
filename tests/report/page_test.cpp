// SPDX-License-Identifier: MIT

#include "libshape/report/page.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "libshape/base/error.h"
#include "libshape/report/base64.h"
#include "libshape/report/plot.h"
#include "tests/report/xml.h"

namespace shape {
using namespace internal;
namespace {

constexpr std::string_view frame =
    "<html>\n<head><!--shape:title--></head>\n<body>\n<section><!--shape:pictures--></section>\n"
    "<section><!--shape:tables--></section>\n<!--shape:data-->\n</body>\n</html>\n";

Page sample()
{
    Plot plot;
    plot.series.push_back({"", Eigen::MatrixX2d::Identity(2, 2), {}, true});
    return {.title = "A <model> & more",
            .facts = {{"Meshes", "7"}, {"File", "<a>.h5"}},
            .pictures = plot_svg(plot),
            .drawings = {plot_svg(plot)},
            .table = {{"Mode", "Variance"}, {"1", "0.5"}, {"2", "<0.1"}},
            .model = R"({"name": "</script><b>"})",
            .block = {0, 1, 2, 255}};
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
    const std::string html = page_html(sample(), frame);
    const auto elements = test::parse_xml(html);
    EXPECT_EQ(texts(elements, "title").front(), "A <model> & more");
    EXPECT_EQ(texts(elements, "dt"), (std::vector<std::string>{"Meshes", "File"}));
    EXPECT_EQ(texts(elements, "dd"), (std::vector<std::string>{"7", "<a>.h5"}));
    EXPECT_EQ(texts(elements, "th"), (std::vector<std::string>{"Mode", "Variance", "1", "2"}));
    EXPECT_EQ(texts(elements, "td"), (std::vector<std::string>{"0.5", "<0.1"}));
    EXPECT_EQ(test::named(elements, "svg").size(), 2U);
    EXPECT_EQ(html, page_html(sample(), frame));
}

TEST(PageHtml, CarriesTheModelAndItsBlock)
{
    const auto scripts = texts(test::parse_xml(page_html(sample(), frame)), "script");
    ASSERT_EQ(scripts.size(), 2U);
    EXPECT_EQ(nlohmann::json::parse(scripts[0])["name"], "</script><b>");
    EXPECT_EQ(scripts[0].find('<'), std::string::npos); // nothing ends the script
    EXPECT_EQ(scripts[1], base64({"\x00\x01\x02\xff", 4}) + "\n");
}

TEST(PageHtml, CutsALongBlockIntoLinesThatCanBeDecodedOneByOne)
{
    Page page = sample();
    page.block.assign((3U << 20U) + 1, 7);
    const std::string text = texts(test::parse_xml(page_html(page, frame)), "script")[1];
    const std::size_t end = text.find('\n');
    EXPECT_EQ(end, std::size_t{4} << 20U);
    EXPECT_EQ(text.substr(end + 1), base64("\x07") + "\n");
}

TEST(PageHtml, RefusesAFrameWithoutAMark)
{
    for (const std::string mark : {"title", "pictures", "tables", "data"}) {
        std::string broken(frame);
        const std::string whole = "<!--shape:" + mark + "-->";
        broken.erase(broken.find(whole), whole.size());
        try {
            (void)page_html(sample(), broken);
            ADD_FAILURE() << mark;
        } catch (const InvalidInput& error) {
            EXPECT_NE(std::string(error.what()).find(mark), std::string::npos);
        }
    }
}

} // namespace
} // namespace shape
