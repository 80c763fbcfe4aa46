// SPDX-License-Identifier: MIT

#include "libshape/report/picture.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <mutex>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/require.h"
#include "libshape/base/threads.h"
#include "libshape/base/to_size.h"
#include "libshape/mesh/alignment.h"

namespace shape {
using namespace internal;
namespace {

constexpr double page_width = 1200.0; // [px]
constexpr double caption_height = 24.0;
constexpr double bar_height = 44.0;
constexpr Colour paper{255, 255, 255};

void check_meshes(const Collection& collection, const PictureOptions& options)
{
    if (collection.size() == 0)
        throw InvalidInput("a picture needs at least one mesh");
    if (options.values.empty())
        return;
    if (options.values.size() != collection.size())
        throw InvalidInput(join("values has ", options.values.size(), " entries for ",
                                collection.size(), " meshes"));
    for (std::size_t i = 0; i < options.values.size(); ++i)
        if (options.values[i].size() != collection.topology.vertex_count())
            throw InvalidInput(join("values[", i, "] has ", options.values[i].size(),
                                    " entries, the mesh has ", collection.topology.vertex_count(),
                                    " vertices"));
}

std::vector<Colour> colours_of(const Eigen::VectorXd& values, const PictureOptions& options)
{
    std::vector<Colour> colours;
    for (const double value : values)
        colours.push_back(
            map_colour(options.colour_map,
                       (value - options.value_low) / (options.value_high - options.value_low)));
    return colours;
}

/// The colours of the values, their ends and their name.
void draw_colour_bar(Svg& svg, const Picture::ColourBar& bar, double middle, double top)
{
    constexpr int width = 200; // [px]
    constexpr double height = 12.0;
    Image colours(width, 1, paper);
    for (int x = 0; x < width; ++x)
        colours.at(x, 0) = map_colour(bar.map, x / (width - 1.0));
    Image swatch(width, static_cast<int>(height), paper);
    for (int y = 0; y < swatch.height; ++y)
        swatch.paste(colours, 0, y);
    const auto number = [](double value) {
        std::array<char, 32> digits{};
        const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), value,
                                       std::chars_format::general, 3);
        return std::string(digits.data(), end.ptr);
    };
    const double left = middle - 0.5 * width;
    svg.image(left, top, width, height, swatch);
    svg.text(left - 6.0, top + height - 2.0, number(bar.low), {.anchor = TextAnchor::End});
    svg.text(left + width + 6.0, top + height - 2.0, number(bar.high));
    svg.text(middle, top + height + 16.0, bar.name, {.anchor = TextAnchor::Middle});
}

void draw_picture(Svg& svg, const Picture& picture, double left)
{
    svg.image(left, 0.0, picture.width(), picture.height(), picture.sheet);
    for (const Picture::Caption& caption : picture.captions)
        svg.text(left + caption.x, caption.y, caption.text,
                 {.size = caption.size, .anchor = TextAnchor::Middle});
}

} // namespace

void check(const PictureOptions& options)
{
    require_at_least(0, options.columns, "PictureOptions.columns");
    require(options.cell_width >= 16 && options.cell_width <= 4096, "PictureOptions.cell_width",
            options.cell_width, "in [16, 4096]");
    require(options.scale >= 1 && options.scale <= 4, "PictureOptions.scale", options.scale,
            "in [1, 4]");
    require(std::isfinite(options.value_low), "PictureOptions.value_low", options.value_low,
            "finite");
    require(std::isfinite(options.value_high) && options.value_high > options.value_low,
            "PictureOptions.value_high", options.value_high,
            join("> value_low, ", options.value_low, ", and finite"));
}

Picture draw_collection(const Collection& collection, const PictureOptions& options,
                        const Progress& progress)
{
    check(options);
    check_meshes(collection, options);
    const Faces& faces = collection.topology.faces();
    const Points& first = collection.points.front();
    const Eigen::Matrix3d rotation =
        options.view ? view_rotation(*options.view) : automatic_view(faces, first);
    std::vector<Points> seen;
    Eigen::RowVector3d low = Eigen::RowVector3d::Constant(std::numeric_limits<double>::infinity());
    Eigen::RowVector3d high = -low;
    Points onto = first;
    for (const Points& points : collection.points) {
        const Points moved = best_rigid_motion(points, onto)(points);
        if (options.is_sequence)
            onto = moved;
        seen.emplace_back(moved * rotation.transpose());
        low = low.cwiseMin(seen.back().colwise().minCoeff());
        high = high.cwiseMax(seen.back().colwise().maxCoeff());
    }
    // Cells take the form of what is in them, within limits.
    const Eigen::RowVector3d size = (1.08 * (high - low)).cwiseMax(1e-9 * (high - low).norm());
    const double form = std::clamp(size.y() / size.x(), 0.4, 1.8);
    const double cell_width = options.cell_width;
    const double cell_height = std::round(cell_width * form);
    const int count = static_cast<int>(collection.size());
    const int fitting = std::max(1, static_cast<int>(page_width / cell_width));
    const int rows_if_fitting = (count + fitting - 1) / fitting;
    const int columns = options.columns > 0 ? std::min(options.columns, count)
                                            : (count + rows_if_fitting - 1) / rows_if_fitting;
    const int rows = (count + columns - 1) / columns;

    const auto pixels = [&](double length) {
        return static_cast<int>(std::lround(length * options.scale));
    };
    const int sheet_width = columns * pixels(cell_width);
    const double pitch = cell_height + caption_height;
    if (static_cast<double>(sheet_width) * rows * pixels(pitch) > 0x1p28)
        throw LimitExceeded(join("the sheet would be ", sheet_width, " by ", rows * pixels(pitch),
                                 " pixels, more than 2^28; draw fewer meshes or smaller cells"));
    Picture picture{Image(sheet_width, rows * pixels(pitch), paper), options.scale, {}, {}};
    RenderOptions render;
    render.width = pixels(cell_width);
    render.height = pixels(cell_height);
    render.centre = (0.5 * (low + high)).head<2>().transpose();
    render.pixel_size = std::max(size.x() / render.width, size.y() / render.height);
    render.background = paper;
    if (faces.rows() < 200)
        render.crease_angle = 1.0; // so few faces are meant to be seen
    std::vector<Image> cells(collection.size());
    std::mutex reporting;
    std::size_t drawn = 0;
    parallel_for(collection.size(), 1, [&](std::size_t i, std::size_t) {
        if (progress) {
            const std::lock_guard lock(reporting);
            progress("drawing", drawn++, cells.size());
        }
        RenderOptions own = render;
        if (!options.values.empty())
            own.vertex_colours = colours_of(options.values[i], options);
        cells[i] = render_mesh(faces, seen[i], own);
    });
    for (int i = 0; i < count; ++i) {
        const int column = i % columns;
        const int row = i / columns;
        picture.sheet.paste(cells[to_size(i)], column * render.width, row * pixels(pitch));
        const std::string& name = collection.names[to_size(i)];
        const double letters =
            std::min(12.0, cell_width / std::max(1.0, text_width(name, 1.0) + 1.0));
        picture.captions.push_back(
            {(column + 0.5) * cell_width, (row + 1) * pitch - 8.0, letters, name});
    }
    if (progress)
        progress("drawing", cells.size(), cells.size());
    if (!options.values.empty())
        picture.colour_bar = {options.colour_map, options.value_low, options.value_high,
                              options.value_name};
    return picture;
}

std::string picture_svg(const Picture& picture)
{
    if (!picture.colour_bar) {
        Svg svg(picture.width(), picture.height());
        draw_picture(svg, picture, 0.0);
        return svg.document();
    }
    const double width = std::max(picture.width(), 320.0);
    Svg svg(width, picture.height() + bar_height);
    svg.rectangle(0.0, 0.0, width, picture.height() + bar_height, paper);
    draw_picture(svg, picture, 0.5 * (width - picture.width()));
    draw_colour_bar(svg, *picture.colour_bar, 0.5 * width, picture.height() + 8.0);
    return svg.document();
}

std::string overview_svg(const Picture& picture, const Plot& plot)
{
    const double width = std::max(picture.width(), 640.0);
    const double plot_width = std::min(width, 900.0);
    const double plot_height = 0.6 * plot_width;
    Svg svg(width, picture.height() + plot_height);
    svg.rectangle(0.0, 0.0, width, picture.height() + plot_height, paper);
    draw_picture(svg, picture, 0.5 * (width - picture.width()));
    draw_plot(svg, {0.5 * (width - plot_width), picture.height(), plot_width, plot_height}, plot);
    return svg.document();
}

} // namespace shape
