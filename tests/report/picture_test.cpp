// SPDX-License-Identifier: MIT

#include "libshape/report/picture.h"

#include <gtest/gtest.h>

#include "libshape/base/error.h"
#include "libshape/base/threads.h"
#include "libshape/synthetic/synthetic.h"
#include "tests/report/xml.h"
#include "tests/support/meshes.h"

namespace shape {
namespace {

Collection three_poses()
{
    return make_synthetic("arm", {.count = 3, .vertices = 300});
}

PictureOptions small_cells()
{
    PictureOptions options;
    options.cell_width = 40;
    options.scale = 1;
    return options;
}

TEST(DrawCollection, HasACellAndACaptionForEachMesh)
{
    PictureOptions options = small_cells();
    options.columns = 2;
    const Picture picture = draw_collection(three_poses(), options);
    EXPECT_EQ(picture.sheet.width, 80);
    ASSERT_EQ(picture.captions.size(), 3U);
    EXPECT_EQ(picture.captions[1].text, "arm_0001");
    EXPECT_EQ(picture.captions[0].x, 20.0);
    EXPECT_EQ(picture.captions[1].x, 60.0);
    EXPECT_EQ(picture.captions[2].x, 20.0);
    EXPECT_EQ(picture.captions[2].y - picture.captions[0].y, 0.5 * picture.height());
    // Cell by cell: three are drawn, the fourth is empty.
    const auto drawn = [&](int column, int row) {
        int count = 0;
        for (int y = row * picture.sheet.height / 2; y < (row + 1) * picture.sheet.height / 2; ++y)
            for (int x = 40 * column; x < 40 * (column + 1); ++x)
                count += picture.sheet.at(x, y) == Colour{255, 255, 255} ? 0 : 1;
        return count;
    };
    EXPECT_GT(drawn(0, 0), 100);
    EXPECT_GT(drawn(1, 0), 100);
    EXPECT_GT(drawn(0, 1), 100);
    EXPECT_EQ(drawn(1, 1), 0);
}

TEST(DrawCollection, GivesTheSameBytesWithAnyNumberOfThreads)
{
    const int before = thread_count();
    set_thread_count(1);
    const std::string one = picture_svg(draw_collection(three_poses(), small_cells()));
    set_thread_count(3);
    const std::string three = picture_svg(draw_collection(three_poses(), small_cells()));
    set_thread_count(before);
    EXPECT_EQ(one, three);
}

TEST(DrawCollection, SaysHowFarItIsAndCanBeStopped)
{
    std::vector<std::size_t> said;
    (void)draw_collection(three_poses(), small_cells(),
                          [&](std::string_view, std::size_t done, std::size_t total) {
                              EXPECT_EQ(total, 3U);
                              said.push_back(done);
                          });
    EXPECT_EQ(said, (std::vector<std::size_t>{0, 1, 2, 3}));
    EXPECT_THROW((void)draw_collection(
                     three_poses(), small_cells(),
                     [](std::string_view, std::size_t, std::size_t) { throw Interrupted("stop"); }),
                 Interrupted);
}

TEST(DrawCollection, MakesALongNameFitItsCell)
{
    Collection set = three_poses();
    set.names[1] = std::string(60, 'x');
    PictureOptions options = small_cells();
    options.cell_width = 200;
    const Picture picture = draw_collection(set, options);
    EXPECT_EQ(picture.captions[0].size, 12.0);
    EXPECT_LT(text_width(set.names[1], picture.captions[1].size), 200.0);
}

TEST(DrawCollection, DoesNotCareWhereAMeshLies)
{
    Collection set = three_poses();
    const Image still = draw_collection(set, small_cells()).sheet;
    set.points[1] = test::moved(set.points[1], 3);
    const Image moved = draw_collection(set, small_cells()).sheet;
    ASSERT_EQ(still.pixels.size(), moved.pixels.size());
    int different = 0;
    for (std::size_t i = 0; i < still.pixels.size(); ++i)
        different += std::abs(still.pixels[i].green - moved.pixels[i].green) > 12 ? 1 : 0;
    EXPECT_LT(different, 20); // rounding moves a few samples over an edge
}

TEST(DrawCollection, MovesEachMeshOfASequenceOntoTheOneBefore)
{
    // Bent to one side, straight, bent to the other: turned over, the last looks like the first.
    Collection set = three_poses();
    set.points[1] = set.points[0];
    set.points[0] = set.points[2];
    set.points[0].col(1) *= -1.0;
    PictureOptions options = small_cells();
    options.cell_width = 100;
    options.view = ViewDirection{.azimuth = 0.0, .elevation = 0.0};
    const auto difference_of_first_and_last = [&] {
        const Image sheet = draw_collection(set, options).sheet;
        int different = 0;
        for (int y = 0; y < sheet.height; ++y)
            for (int x = 0; x < 100; ++x)
                different += (sheet.at(x, y).green < 255) != (sheet.at(200 + x, y).green < 255);
        return different;
    };
    EXPECT_LT(difference_of_first_and_last(), 50);
    options.is_sequence = true;
    EXPECT_GT(difference_of_first_and_last(), 500);
}

TEST(DrawCollection, ColoursByValue)
{
    const Collection set = make_synthetic("icosahedron");
    PictureOptions options = small_cells();
    options.colour_map = ColourMap::Diverging;
    options.value_low = -1.0;
    options.values = {Eigen::VectorXd::Constant(12, -1.0), Eigen::VectorXd::Constant(12, 1.0)};
    const Image sheet = draw_collection(set, options).sheet;
    const Colour low = sheet.at(20, 20);
    const Colour high = sheet.at(60, 20);
    EXPECT_GT(low.blue, low.red);
    EXPECT_GT(high.red, high.blue);
}

TEST(DrawCollection, RefusesOptionsOutOfRange)
{
    const Collection set = make_synthetic("icosahedron");
    const auto with = [](const auto& change) {
        PictureOptions options = small_cells();
        change(options);
        return options;
    };
    const auto refused = [&](const auto& change) {
        EXPECT_THROW((void)draw_collection(set, with(change)), InvalidInput);
    };
    refused([](PictureOptions& o) { o.columns = -1; });
    refused([](PictureOptions& o) { o.cell_width = 15; });
    refused([](PictureOptions& o) { o.cell_width = 5000; });
    refused([](PictureOptions& o) { o.scale = 0; });
    refused([](PictureOptions& o) { o.scale = 5; });
    refused([](PictureOptions& o) { o.values = {Eigen::VectorXd::Zero(12)}; });
    refused([](PictureOptions& o) { o.values.assign(2, Eigen::VectorXd::Zero(5)); });
    refused([](PictureOptions& o) {
        o.values.assign(2, Eigen::VectorXd::Zero(12));
        o.value_low = 1.0;
    });
    EXPECT_THROW((void)draw_collection(set, with([](PictureOptions& o) {
                                           o.cell_width = 4096;
                                           o.scale = 4;
                                       })),
                 LimitExceeded);
    Collection none{set.topology, {}, {}, {}};
    EXPECT_THROW((void)draw_collection(none, small_cells()), InvalidInput);
}

TEST(PictureSvg, IsWellFormedWithStrangeNames)
{
    Collection set = three_poses();
    set.names[1] = "<a & 'b'>";
    const auto elements = test::parse_xml(picture_svg(draw_collection(set, small_cells())));
    EXPECT_EQ(test::named(elements, "image").size(), 1U);
    ASSERT_EQ(test::named(elements, "text").size(), 3U);
    EXPECT_EQ(test::named(elements, "text")[1].text, "<a & 'b'>");
}

TEST(PictureSvg, HasAColourBarBelowMeshesColouredByValues)
{
    PictureOptions options = small_cells();
    options.values.assign(2, Eigen::VectorXd::Zero(12));
    options.value_low = -0.25;
    options.value_high = 1234.5;
    options.value_name = "edge_error";
    const Picture picture = draw_collection(make_synthetic("icosahedron"), options);
    const auto elements = test::parse_xml(picture_svg(picture));
    ASSERT_EQ(test::named(elements, "image").size(), 2U);
    EXPECT_GE(std::stod(test::named(elements, "image")[1].attributes.at("y")), picture.height());
    const auto texts = test::named(elements, "text");
    ASSERT_EQ(texts.size(), 5U);
    EXPECT_EQ(texts[2].text, "-0.25");
    EXPECT_EQ(texts[3].text, "1.23e+03");
    EXPECT_EQ(texts[4].text, "edge_error");
}

TEST(OverviewSvg, HasThePictureAboveThePlot)
{
    Plot plot{.title = "t", .x_label = "x", .y_label = "y", .series = {}, .equal_axes = false};
    plot.series.push_back({"s", Eigen::MatrixX2d::Random(5, 2), {}, false});
    const Picture picture = draw_collection(three_poses(), small_cells());
    const auto elements = test::parse_xml(overview_svg(picture, plot));
    const double bottom =
        std::stod(test::named(elements, "image").at(0).attributes.at("y")) + picture.height();
    for (const test::XmlElement& line : test::named(elements, "line"))
        EXPECT_GT(std::stod(line.attributes.at("y1")), bottom);
    EXPECT_EQ(test::named(elements, "path").size(), 5U);
}

} // namespace
} // namespace shape
