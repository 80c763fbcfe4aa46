// SPDX-License-Identifier: MIT

#include "libshape/report/heat_map.h"

#include <algorithm>
#include <cmath>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/to_size.h"
#include "libshape/report/colour_map.h"
#include "libshape/report/svg.h"

namespace shape {
using namespace internal;
namespace {

constexpr double tree_height = 110.0; // [px], as all below
constexpr double strip_width = 14.0;
constexpr double outer_margin = 20.0;
constexpr double legend_line = 18.0;
constexpr double legible = 9.0; ///< Smallest cell whose name can be read.
constexpr Colour tree_colour{90, 90, 90};

void check(const HeatMap& map)
{
    const std::size_t count = map.names.size();
    const auto rows = static_cast<Eigen::Index>(count);
    if (count == 0 || map.distances.rows() != rows || map.distances.cols() != rows ||
        map.clustering.order.size() != count ||
        (!map.label_values.empty() && map.label_values.size() != count))
        throw InvalidInput(join("heat map: ", count, " names, ", map.distances.rows(), " by ",
                                map.distances.cols(), " distances, ", map.clustering.order.size(),
                                " things in the tree and ", map.label_values.size(),
                                " label values do not fit together"));
}

/// Cells of whole pixels, so that no cell is blurred.
int cell_size(std::size_t count)
{
    return std::max(1, static_cast<int>(600 / count));
}

Image cells(const HeatMap& map, int cell, double largest)
{
    const auto count = static_cast<int>(map.names.size());
    Image image(count * cell, count * cell, {255, 255, 255});
    for (int row = 0; row < count; ++row)
        for (int column = 0; column < count; ++column) {
            const double distance = map.distances(map.clustering.order[to_size(row)],
                                                  map.clustering.order[to_size(column)]);
            image.paste(
                Image(cell, cell,
                      map_colour(ColourMap::Sequential, largest > 0.0 ? distance / largest : 0.0)),
                column * cell, row * cell);
        }
    return image;
}

void draw_tree(Svg& svg, const Clustering& clustering, double left, double bottom, double cell)
{
    const std::size_t count = clustering.order.size();
    std::vector<Eigen::Vector2d> top(2 * count - 1); // of every cluster
    for (std::size_t position = 0; position < count; ++position)
        top[to_size(clustering.order[position])] = {
            left + (static_cast<double>(position) + 0.5) * cell, bottom};
    const double highest = clustering.merges.empty() ? 0.0 : clustering.merges.back().height;
    for (std::size_t k = 0; k < clustering.merges.size(); ++k) {
        const Merge& merge = clustering.merges[k];
        const Eigen::Vector2d a = top[to_size(merge.first)];
        const Eigen::Vector2d b = top[to_size(merge.second)];
        const double y = bottom - (highest > 0.0 ? tree_height * merge.height / highest : 0.0);
        Eigen::MatrixX2d bracket(4, 2);
        bracket << a.x(), a.y(), a.x(), y, b.x(), y, b.x(), b.y();
        svg.polyline(bracket, tree_colour, cell < 4.0 ? 0.4 : 1.0);
        top[count + k] = {0.5 * (a.x() + b.x()), y};
    }
}

std::vector<std::string> different(const std::vector<std::string>& values)
{
    std::vector<std::string> found;
    for (const std::string& value : values)
        if (std::find(found.begin(), found.end(), value) == found.end())
            found.push_back(value);
    return found;
}

/// The values of the labels, in rows of as many as a width takes.
struct Legend
{
    std::vector<std::string> values;
    std::size_t columns = 1;
    double pitch = 0.0; ///< From column to column.

    [[nodiscard]] double height() const
    {
        const std::size_t rows = (values.size() + columns - 1) / columns;
        return legend_line * static_cast<double>(rows);
    }
};

Legend legend_of(const HeatMap& map, double width)
{
    Legend legend;
    legend.values = different(map.label_values);
    for (const std::string& value : legend.values)
        legend.pitch = std::max(legend.pitch, 32.0 + text_width(value, 12.0));
    if (!legend.values.empty())
        legend.columns = std::max<std::size_t>(1, static_cast<std::size_t>(width / legend.pitch));
    return legend;
}

void draw_labels(Svg& svg, const HeatMap& map, const Legend& legend, double left, double top,
                 double cell, double bottom)
{
    const std::vector<std::string>& values = legend.values;
    const auto category = [&](const std::string& value) {
        return to_size(std::find(values.begin(), values.end(), value) - values.begin());
    };
    for (std::size_t position = 0; position < map.names.size(); ++position) {
        const auto thing = to_size(map.clustering.order[position]);
        svg.rectangle(left, top + static_cast<double>(position) * cell, strip_width - 4.0, cell,
                      category_colour(category(map.label_values[thing])));
    }
    for (std::size_t i = 0; i < values.size(); ++i) {
        const std::size_t row = i / legend.columns;
        const double x = left + legend.pitch * static_cast<double>(i % legend.columns);
        const double y = bottom + legend_line * static_cast<double>(row);
        svg.rectangle(x, y - 5.0, 10.0, 10.0, category_colour(i));
        svg.text(x + 16.0, y + 4.0, values[i]);
    }
}

/// The colours from 0 to the largest distance.
void draw_scale(Svg& svg, double left, double top, double largest)
{
    constexpr int steps = 60;
    Image bar(steps, 1, {});
    for (int i = 0; i < steps; ++i)
        bar.at(i, 0) = map_colour(ColourMap::Sequential, (i + 0.5) / steps);
    Image tall(3 * steps, 12, {});
    for (int x = 0; x < tall.width; ++x)
        for (int y = 0; y < tall.height; ++y)
            tall.at(x, y) = bar.at(x / 3, 0);
    svg.image(left, top, tall.width, tall.height, tall);
    svg.text(left, top + 26.0, "0");
    svg.text(left + tall.width, top + 26.0, join(largest), {.anchor = TextAnchor::End});
}

} // namespace

std::string heat_map_svg(const HeatMap& map)
{
    check(map);
    const auto count = static_cast<double>(map.names.size());
    const int cell = cell_size(map.names.size());
    const double side = count * cell;
    const double largest = map.distances.maxCoeff();
    const bool labelled = !map.label_values.empty();
    const bool named = cell >= legible;
    const double text_size = std::min(12.0, static_cast<double>(cell));
    double names_width = 0.0;
    if (named)
        for (const std::string& name : map.names)
            names_width = std::max(names_width, 8.0 + text_width(name, text_size));
    const double left = outer_margin + (labelled ? strip_width : 0.0);
    const double top = outer_margin + (map.title.empty() ? 0.0 : 24.0) + tree_height + 6.0;
    const double width = left + std::max(side + names_width, 220.0) + outer_margin;
    const Legend legend = legend_of(map, width - 2.0 * outer_margin);
    const double bottom = top + side + 46.0 + outer_margin;
    const double height = bottom + legend.height();
    Svg svg(width, height);
    svg.rectangle(0.0, 0.0, width, height, {255, 255, 255});
    if (!map.title.empty())
        svg.text(left, outer_margin + 8.0, map.title, {.size = 14.0, .bold = true});
    draw_tree(svg, map.clustering, left, top - 4.0, cell);
    svg.image(left, top, side, side, cells(map, cell, largest));
    for (std::size_t position = 0; named && position < map.names.size(); ++position)
        svg.text(left + side + 6.0,
                 top + (static_cast<double>(position) + 0.5) * cell + 0.35 * text_size,
                 map.names[to_size(map.clustering.order[position])], {.size = text_size});
    if (labelled)
        draw_labels(svg, map, legend, left - strip_width, top, cell, bottom);
    draw_scale(svg, left, top + side + 12.0, largest);
    return svg.document();
}

} // namespace shape
