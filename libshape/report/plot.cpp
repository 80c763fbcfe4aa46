// SPDX-License-Identifier: MIT

#include "libshape/report/plot.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/to_size.h"
#include "libshape/report/colour_map.h"

namespace shape {
using namespace internal;
namespace {

constexpr Colour grid_colour{232, 232, 232};
constexpr Colour axis_colour{110, 110, 110};

/// Values from low to high on pixels from begin to end.
struct Axis
{
    std::vector<double> ticks; ///< Between low and high.
    double low = 0.0;
    double high = 1.0;
    double begin = 0.0;
    double end = 1.0;

    [[nodiscard]] double operator()(double value) const
    {
        return begin + (end - begin) * (value - low) / (high - low);
    }
    [[nodiscard]] double unit() const { return std::abs(end - begin) / (high - low); }
};

struct Extent
{
    double low = std::numeric_limits<double>::infinity();
    double high = -std::numeric_limits<double>::infinity();

    void include(double value)
    {
        low = std::min(low, value);
        high = std::max(high, value);
    }
};

Axis fitted_axis(Extent extent, double begin, double end)
{
    if (extent.low > extent.high)
        extent = {0.0, 1.0};
    const int wanted = std::max(4, static_cast<int>(std::abs(end - begin) / 90.0));
    std::vector<double> ticks = round_ticks(extent.low, extent.high, wanted);
    // The data with a margin, or all ticks where these leave no more room.
    const double margin = 0.04 * (extent.high - extent.low);
    double low = std::max(ticks.front(), extent.low - margin);
    double high = std::min(ticks.back(), extent.high + margin);
    if (high - low < ticks[1] - ticks[0]) { // data as good as equal
        low = ticks.front();
        high = ticks.back();
    }
    std::erase_if(ticks, [&](double tick) { return tick < low || tick > high; });
    return {std::move(ticks), low, high, begin, end};
}

/// Shrinks the axis with the longer unit about its middle.
void make_equal(Axis& x, Axis& y)
{
    const double unit = std::min(x.unit(), y.unit());
    for (Axis* axis : {&x, &y}) {
        const double middle = 0.5 * (axis->begin + axis->end);
        const double half = 0.5 * (axis->end - axis->begin) * unit / axis->unit();
        axis->begin = middle - half;
        axis->end = middle + half;
    }
}

/// A tick's value with as many decimals as the step has.
std::string tick_text(double value, double step)
{
    const double clean = std::abs(value) < 0.5 * step ? 0.0 : value;
    const bool plain = step >= 1e-5 && std::abs(value) < 1e7;
    const int decimals = std::max(0, -static_cast<int>(std::floor(std::log10(step) + 1e-9)));
    std::array<char, 64> digits{};
    const auto end = plain ? std::to_chars(digits.data(), digits.data() + digits.size(), clean,
                                           std::chars_format::fixed, decimals)
                           : std::to_chars(digits.data(), digits.data() + digits.size(), clean,
                                           std::chars_format::general, 6);
    std::string text(digits.data(), end.ptr);
    if (text.front() == '-')
        text.replace(0, 1, "\u2212");
    return text;
}

Marker marker_of(std::size_t series)
{
    constexpr std::array markers{Marker::Circle, Marker::Square, Marker::Triangle, Marker::Diamond};
    return markers[series % markers.size()];
}

/// A series in the legend, its mark's left end from that of the legend and its row from below.
struct LegendEntry
{
    std::size_t series = 0;
    double left = 0.0;
    int row = 0;
};

constexpr double legend_row = 18.0; // [px], as all below
constexpr double legend_mark = 18.0;
constexpr double legend_gap = 18.0;
constexpr double legend_size = 12.0; ///< Its letters are this high.

/// The series that have a name, in as many rows as a width needs; none if fewer than two have one.
std::vector<LegendEntry> legend_of(const Plot& plot, double width)
{
    std::vector<LegendEntry> entries;
    double left = 0.0;
    int row = 0;
    for (std::size_t s = 0; s < plot.series.size(); ++s) {
        const std::string& name = plot.series[s].name;
        if (name.empty())
            continue;
        const double taken = legend_mark + text_width(name, legend_size);
        if (left > 0.0 && left + taken > width) {
            left = 0.0;
            ++row;
        }
        entries.push_back({s, left, row});
        left += taken + legend_gap;
    }
    if (entries.size() < 2)
        return {};
    for (LegendEntry& entry : entries)
        entry.row = row - entry.row;
    return entries;
}

constexpr double scale_width = 76.0; ///< Of the scale of colours with its numbers [px].

/// Colours of values: dark for low ones, never so light that they fade on white.
struct ColourScale
{
    Extent extent;

    [[nodiscard]] bool is_used() const { return extent.low <= extent.high; }
    [[nodiscard]] Colour operator()(double value) const
    {
        const double range = extent.high - extent.low;
        const double place = range > 0.0 ? (value - extent.low) / range : 0.5;
        return map_colour(ColourMap::Sequential, 0.85 * place);
    }
};

ColourScale scale_of(const Plot& plot)
{
    ColourScale scale;
    for (const Series& series : plot.series)
        for (const double value : series.values)
            if (std::isfinite(value))
                scale.extent.include(value);
    return scale;
}

void draw_scale(Svg& svg, const ColourScale& scale, const std::string& label, double left,
                double top, double bottom)
{
    constexpr int steps = 64;
    constexpr double width = 12.0;
    const double height = (bottom - top) / steps;
    for (int i = 0; i < steps; ++i) {
        const double value =
            scale.extent.high - (scale.extent.high - scale.extent.low) * (i + 0.5) / steps;
        svg.rectangle(left, top + i * height, width, height + 0.5, scale(value));
    }
    const Axis axis = fitted_axis(scale.extent, bottom, top);
    const double step = axis.ticks.size() > 1 ? axis.ticks[1] - axis.ticks[0] : 1.0;
    const double range = scale.extent.high - scale.extent.low;
    for (const double tick : axis.ticks)
        if (tick >= scale.extent.low && tick <= scale.extent.high && range > 0.0) {
            const double y = bottom + (top - bottom) * (tick - scale.extent.low) / range;
            svg.line(left + width, y, left + width + 3.0, y, axis_colour);
            svg.text(left + width + 6.0, y + 4.0, tick_text(tick, step),
                     {.size = 11.0, .colour = axis_colour});
        }
    if (!label.empty())
        svg.text(left, top - 8.0, label, {.size = 12.0});
}

/// Names beside points: right, left, above or below, where they cover no other name and no point;
/// where none of these is free, the name is left to the tip.
class PointNames
{
public:
    PointNames(Svg& svg, double left, double right) : svg_(svg), left_(left), right_(right) {}

    void add_point(double x, double y) { taken_.push_back({x - 3.0, y - 3.0, 6.0, 6.0}); }

    void write(double x, double y, const std::string& name)
    {
        constexpr double size = 10.0;
        const double width = text_width(name, size);
        const std::array<Box, 4> places{{{x + 6.0, y - 5.0, width, size},
                                         {x - 6.0 - width, y - 5.0, width, size},
                                         {x - 0.5 * width, y - 6.0 - size, width, size},
                                         {x - 0.5 * width, y + 6.0, width, size}}};
        for (const Box& place : places)
            if (place.x >= left_ && place.x + place.width <= right_ && is_free(place)) {
                svg_.text(place.x, place.y + 0.85 * size, name, {.size = size});
                taken_.push_back(place);
                return;
            }
    }

private:
    [[nodiscard]] bool is_free(const Box& place) const
    {
        return std::ranges::none_of(taken_, [&](const Box& other) {
            return place.x < other.x + other.width && other.x < place.x + place.width &&
                   place.y < other.y + other.height && other.y < place.y + place.height;
        });
    }

    Svg& svg_;
    double left_;
    double right_;
    std::vector<Box> taken_;
};

void draw_deviations(Svg& svg, const Series& series, const Axis& x, const Axis& y, Colour colour)
{
    for (Eigen::Index i = 0; i < series.deviations.size(); ++i) {
        const double deviation = series.deviations[i];
        if (!series.points.row(i).allFinite() || !(deviation > 0.0) || !std::isfinite(deviation))
            continue;
        const double place = x(series.points(i, 0));
        const double low = y(series.points(i, 1) - deviation);
        const double high = y(series.points(i, 1) + deviation);
        svg.line(place, low, place, high, colour);
        for (const double end : {low, high})
            svg.line(place - 3.0, end, place + 3.0, end, colour);
    }
}

void check_sizes(const Series& series)
{
    const auto check = [&](Eigen::Index size, const char* what) {
        if (size != 0 && size != series.points.rows())
            throw InvalidInput(join("series '", series.name, "' has ", size, " ", what, " for ",
                                    series.points.rows(), " points"));
    };
    check(static_cast<Eigen::Index>(series.tips.size()), "tips");
    check(series.values.size(), "values");
    check(series.deviations.size(), "deviations");
}

Colour colour_of(const Plot& plot, std::size_t series)
{
    return plot.series[series].colour.value_or(category_colour(series));
}

struct PlotExtents
{
    Extent x, y;
};

/// Of all points, with their deviations.
PlotExtents extents_of(const Plot& plot)
{
    PlotExtents extents;
    for (const Series& series : plot.series) {
        check_sizes(series);
        for (Eigen::Index i = 0; i < series.points.rows(); ++i)
            if (series.points.row(i).allFinite()) {
                const double deviation = series.deviations.size() > 0 ? series.deviations[i] : 0.0;
                extents.x.include(series.points(i, 0));
                extents.y.include(series.points(i, 1) - deviation);
                extents.y.include(series.points(i, 1) + deviation);
            }
    }
    return extents;
}

/// The grid, the axes and what is written at them, and the title.
void draw_axes(Svg& svg, const Box& box, const Plot& plot, const Axis& x, const Axis& y)
{
    const double middle = 0.5 * (x.begin + x.end);
    for (const double tick : x.ticks) {
        svg.line(x(tick), y.begin, x(tick), y.end, grid_colour);
        svg.text(x(tick), y.begin + 18.0, tick_text(tick, x.ticks[1] - x.ticks[0]),
                 {.size = 11.0, .anchor = TextAnchor::Middle, .colour = axis_colour});
    }
    for (const double tick : y.ticks) {
        svg.line(x.begin, y(tick), x.end, y(tick), grid_colour);
        svg.text(x.begin - 8.0, y(tick) + 4.0, tick_text(tick, y.ticks[1] - y.ticks[0]),
                 {.size = 11.0, .anchor = TextAnchor::End, .colour = axis_colour});
    }
    svg.line(x.begin, y.begin, x.end, y.begin, axis_colour);
    svg.line(x.begin, y.begin, x.begin, y.end, axis_colour);
    svg.text(middle, y.begin + 40.0, plot.x_label, {.size = 13.0, .anchor = TextAnchor::Middle});
    svg.text(x.begin - 54.0, 0.5 * (y.begin + y.end), plot.y_label,
             {.size = 13.0, .anchor = TextAnchor::Middle, .turn = -90.0});
    if (!plot.title.empty())
        svg.text(middle, box.y + 20.0, plot.title,
                 {.size = 14.0, .anchor = TextAnchor::Middle, .bold = true});
}

/// Fewer points are drawn larger [px].
double marker_size(const Plot& plot)
{
    Eigen::Index total = 0;
    for (const Series& series : plot.series)
        total += series.points.rows();
    return std::clamp(30.0 / std::pow(std::max<double>(1.0, static_cast<double>(total)), 0.25), 5.0,
                      9.0);
}

/// Deviations, points or curves, and after all of them the names of points.
void draw_series(Svg& svg, const Plot& plot, const Axis& x, const Axis& y, const ColourScale& scale,
                 double names_end)
{
    const double size = marker_size(plot);
    PointNames names(svg, x.begin, names_end);
    std::vector<std::pair<Eigen::RowVector2d, std::string>> named;
    for (std::size_t s = 0; s < plot.series.size(); ++s) {
        const Series& series = plot.series[s];
        draw_deviations(svg, series, x, y, colour_of(plot, s));
        Eigen::MatrixX2d places(series.points.rows(), 2);
        Eigen::Index kept = 0;
        for (Eigen::Index i = 0; i < series.points.rows(); ++i) {
            if (!series.points.row(i).allFinite())
                continue;
            places.row(kept++) << x(series.points(i, 0)), y(series.points(i, 1));
            if (series.curve)
                continue;
            const std::string tip = series.tips.empty() ? "" : series.tips[to_size(i)];
            svg.marker(marker_of(s), places(kept - 1, 0), places(kept - 1, 1), size,
                       series.values.size() > 0 ? scale(series.values[i]) : colour_of(plot, s),
                       tip);
            if (plot.point_names) {
                names.add_point(places(kept - 1, 0), places(kept - 1, 1));
                named.emplace_back(places.row(kept - 1), tip);
            }
        }
        if (series.curve)
            svg.polyline(places.topRows(kept), colour_of(plot, s));
    }
    for (const auto& [place, name] : named)
        names.write(place.x(), place.y(), name);
}

/// @param left, top  Where the plot itself begins; the legend is above it.
void draw_legend(Svg& svg, const Plot& plot, const std::vector<LegendEntry>& legend, double left,
                 double top)
{
    for (const LegendEntry& entry : legend) {
        const Series& series = plot.series[entry.series];
        const double x0 = left + entry.left;
        const double y0 = top - 18.0 - legend_row * entry.row;
        if (series.curve)
            svg.line(x0, y0, x0 + 14.0, y0, colour_of(plot, entry.series), 2.0);
        else
            svg.marker(marker_of(entry.series), x0 + 7.0, y0, 9.0, colour_of(plot, entry.series));
        svg.text(x0 + legend_mark, y0 + 4.0, series.name, {.size = legend_size});
    }
}

} // namespace

std::vector<double> round_ticks(double low, double high, int wanted)
{
    const double magnitude = std::max(std::abs(low), std::abs(high));
    constexpr double least = 1e-300; // below, steps lose their digits
    if (high - low <= 1e-9 * magnitude ||
        high - low < least) { // finer steps would drown in rounding
        const double margin = magnitude < least ? 1.0 : 0.1 * magnitude;
        low -= margin;
        high += margin;
    }
    const double rough = (high - low) / std::max(wanted - 1, 1);
    const double power = std::pow(10.0, std::floor(std::log10(rough)));
    const double share = rough / power;
    const double step = power * (share < 1.5 ? 1.0 : share < 3.5 ? 2.0 : share < 7.5 ? 5.0 : 10.0);
    std::vector<double> ticks;
    for (double i = std::floor(low / step); ticks.empty() || ticks.back() < high; i += 1.0)
        ticks.push_back(i * step);
    return ticks;
}

void draw_plot(Svg& svg, const Box& box, const Plot& plot)
{
    const PlotExtents extents = extents_of(plot);
    const double left = box.x + 70.0;
    const ColourScale scale = scale_of(plot);
    const double right = box.x + box.width - 18.0 - (scale.is_used() ? scale_width : 0.0);
    const std::vector<LegendEntry> legend = legend_of(plot, right - left);
    const double legend_height = legend.empty() ? 0.0 : 4.0 + legend_row * (legend[0].row + 1);
    const double top = box.y + 14.0 + (plot.title.empty() ? 0.0 : 22.0) + legend_height +
                       (scale.is_used() ? 14.0 : 0.0);
    Axis x = fitted_axis(extents.x, left, right);
    Axis y = fitted_axis(extents.y, box.y + box.height - 52.0, top);
    if (plot.equal_axes)
        make_equal(x, y);
    draw_axes(svg, box, plot, x, y);
    draw_series(svg, plot, x, y, scale, box.x + box.width);
    if (scale.is_used())
        draw_scale(svg, scale, plot.scale_label, box.x + box.width - scale_width, y.end, y.begin);
    draw_legend(svg, plot, legend, left, top);
}

std::string plot_svg(const Plot& plot, double width, double height)
{
    Svg svg(width, height);
    svg.rectangle(0.0, 0.0, width, height, {255, 255, 255});
    draw_plot(svg, {0.0, 0.0, width, height}, plot);
    return svg.document();
}

} // namespace shape
