// SPDX-License-Identifier: MIT

#include "libshape/report/svg.h"

#include <gtest/gtest.h>
#include <png.h>

#include <cstring>

#include "libshape/base/error.h"
#include "tests/report/xml.h"

namespace shape {
namespace {

std::string decoded_base64(const std::string& text)
{
    const std::string letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string bytes;
    unsigned bits = 0;
    int count = 0;
    for (const char c : text) {
        if (c == '=')
            break;
        bits = bits << 6 | static_cast<unsigned>(letters.find(c));
        count += 6;
        if (count >= 8) {
            count -= 8;
            bytes += static_cast<char>(bits >> count & 255U);
        }
    }
    return bytes;
}

Image decoded_png(const std::string& bytes)
{
    png_image png{};
    png.version = PNG_IMAGE_VERSION;
    EXPECT_TRUE(png_image_begin_read_from_memory(&png, bytes.data(), bytes.size()));
    png.format = PNG_FORMAT_RGB;
    Image image(static_cast<int>(png.width), static_cast<int>(png.height), {});
    EXPECT_TRUE(png_image_finish_read(&png, nullptr, image.pixels.data(), 0, nullptr));
    return image;
}

Image chequered(int width, int height)
{
    Image image(width, height, {10, 20, 30});
    for (int y = 0; y < height; ++y)
        for (int x = y % 2; x < width; x += 2)
            image.at(x, y) = {static_cast<std::uint8_t>(7 * x), static_cast<std::uint8_t>(5 * y),
                              255};
    return image;
}

TEST(Png, GivesEveryPixelBack)
{
    for (const int size : {1, 2, 3, 30}) {
        const Image image = chequered(size, size + 1);
        const Image back = decoded_png(encode_png(image));
        EXPECT_EQ(back.width, image.width);
        EXPECT_EQ(back.height, image.height);
        EXPECT_EQ(back.pixels, image.pixels);
    }
    EXPECT_THROW((void)encode_png(Image()), InvalidInput);
}

TEST(ImagePaste, CutsOffWhatSticksOut)
{
    Image image(3, 3, {0, 0, 0});
    image.paste(Image(2, 2, {9, 9, 9}), 2, -1);
    for (int y = 0; y < 3; ++y)
        for (int x = 0; x < 3; ++x)
            EXPECT_EQ(image.at(x, y), (x == 2 && y == 0 ? Colour{9, 9, 9} : Colour{0, 0, 0}));
}

TEST(EscapeXml, LeavesNothingThatEndsATextOrAnAttribute)
{
    EXPECT_EQ(escape_xml("a<b & \"c\" > 'd'"), "a&lt;b &amp; &quot;c&quot; &gt; &#39;d&#39;");
    EXPECT_EQ(escape_xml(std::string("x\x01\x1b\0y", 5)), "xy");
    EXPECT_EQ(escape_xml("Größe"), "Größe");
}

TEST(Svg, IsWellFormedWhateverTheTextsAre)
{
    Svg svg(100.0, 50.0);
    svg.rectangle(0, 0, 100, 50, {255, 255, 255});
    svg.line(0, 0, 10, 10, {1, 2, 3});
    svg.polyline(Eigen::MatrixX2d::Random(5, 2), {4, 5, 6});
    for (const Marker marker : {Marker::Circle, Marker::Square, Marker::Triangle, Marker::Diamond})
        svg.marker(marker, 1, 2, 3, {7, 8, 9}, "<\"&'>");
    svg.text(1, 2, "</text><script>", {.bold = true, .turn = -90.0});
    svg.image(0, 0, 3, 3, chequered(3, 3));
    const std::vector<test::XmlElement> elements = test::parse_xml(svg.document());
    EXPECT_EQ(test::named(elements, "text").at(0).text, "</text><script>");
    EXPECT_EQ(test::named(elements, "title").at(0).text, "<\"&'>");
    EXPECT_EQ(test::named(elements, "path").size(), 4U);
    EXPECT_EQ(elements.front().attributes.at("viewBox"), "0 0 100 50");
}

TEST(Svg, EmbedsTheImageWhole)
{
    for (const int size : {1, 4, 5, 6}) {
        Svg svg(10.0, 10.0);
        const Image image = chequered(size, size);
        svg.image(0, 0, 10, 10, image);
        const std::string href =
            test::named(test::parse_xml(svg.document()), "image").at(0).attributes.at("href");
        const std::string head = "data:image/png;base64,";
        ASSERT_EQ(href.substr(0, head.size()), head);
        EXPECT_EQ(href.size() % 4, head.size() % 4);
        EXPECT_EQ(decoded_base64(href.substr(head.size())), encode_png(image));
    }
}

TEST(Svg, WritesNumbersWithoutExponentAndMinusZero)
{
    Svg svg(1e7, 2.0);
    svg.line(-0.001, 1e-9, 0.125, 1.0 / 3.0, {});
    const auto line = test::named(test::parse_xml(svg.document()), "line").at(0).attributes;
    EXPECT_EQ(line.at("x1"), "0");
    EXPECT_EQ(line.at("y1"), "0");
    EXPECT_EQ(line.at("x2"), "0.13");
    EXPECT_EQ(line.at("y2"), "0.33");
    EXPECT_NE(svg.document().find("width=\"10000000\""), std::string::npos);
}

} // namespace
} // namespace shape
