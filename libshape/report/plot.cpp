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
    Extent x_extent;
    Extent y_extent;
    for (const Series& series : plot.series) {
        if (!series.tips.empty() &&
            static_cast<Eigen::Index>(series.tips.size()) != series.points.rows())
            throw InvalidInput(join("series '", series.name, "' has ", series.tips.size(),
                                    " tips for ", series.points.rows(), " points"));
        for (const auto& point : series.points.rowwise())
            if (point.allFinite()) {
                x_extent.include(point.x());
                y_extent.include(point.y());
            }
    }
    const double left = box.x + 70.0;
    const double right = box.x + box.width - 18.0;
    const std::vector<LegendEntry> legend = legend_of(plot, right - left);
    const double legend_height = legend.empty() ? 0.0 : 4.0 + legend_row * (legend[0].row + 1);
    const double top = box.y + 14.0 + (plot.title.empty() ? 0.0 : 22.0) + legend_height;
    Axis x = fitted_axis(x_extent, left, right);
    Axis y = fitted_axis(y_extent, box.y + box.height - 52.0, top);
    if (plot.equal_axes)
        make_equal(x, y);
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

    // Fewer points are drawn larger.
    Eigen::Index total = 0;
    for (const Series& series : plot.series)
        total += series.points.rows();
    const double size = std::clamp(
        30.0 / std::pow(std::max<double>(1.0, static_cast<double>(total)), 0.25), 5.0, 9.0);
    for (std::size_t s = 0; s < plot.series.size(); ++s) {
        const Series& series = plot.series[s];
        Eigen::MatrixX2d places(series.points.rows(), 2);
        Eigen::Index kept = 0;
        for (Eigen::Index i = 0; i < series.points.rows(); ++i) {
            if (!series.points.row(i).allFinite())
                continue;
            places.row(kept++) << x(series.points(i, 0)), y(series.points(i, 1));
            if (!series.curve)
                svg.marker(marker_of(s), places(kept - 1, 0), places(kept - 1, 1), size,
                           category_colour(s), series.tips.empty() ? "" : series.tips[to_size(i)]);
        }
        if (series.curve)
            svg.polyline(places.topRows(kept), category_colour(s));
    }
    for (const LegendEntry& entry : legend) {
        const Series& series = plot.series[entry.series];
        const double x0 = left + entry.left;
        const double y0 = top - 18.0 - legend_row * entry.row;
        if (series.curve)
            svg.line(x0, y0, x0 + 14.0, y0, category_colour(entry.series), 2.0);
        else
            svg.marker(marker_of(entry.series), x0 + 7.0, y0, 9.0, category_colour(entry.series));
        svg.text(x0 + legend_mark, y0 + 4.0, series.name, {.size = legend_size});
    }
}

std::string plot_svg(const Plot& plot, double width, double height)
{
    Svg svg(width, height);
    svg.rectangle(0.0, 0.0, width, height, {255, 255, 255});
    draw_plot(svg, {0.0, 0.0, width, height}, plot);
    return svg.document();
}

Plot score_plot(const RowMatrix& scores, const std::vector<std::string>& names,
                const std::vector<std::string>& label_values, const Eigen::VectorXd& explained,
                int mode_x, int mode_y)
{
    const auto count = to_size(scores.rows());
    if (names.size() != count || (!label_values.empty() && label_values.size() != count))
        throw InvalidInput(join("scores has ", count, " rows, but there are ", names.size(),
                                " names and ", label_values.size(), " label values"));
    if (std::min(mode_x, mode_y) < 0 || std::max(mode_x, mode_y) >= scores.cols())
        throw InvalidInput(
            join("modes ", mode_x, " and ", mode_y, " must be in [0, ", scores.cols(), ")"));
    const auto axis_label = [&](int mode) {
        std::string label = join("mode ", mode + 1);
        if (mode < explained.size())
            label += join(" (", std::round(1000.0 * explained[mode]) / 10.0, " % of variance)");
        return label;
    };
    Plot plot{.title = {},
              .x_label = axis_label(mode_x),
              .y_label = axis_label(mode_y),
              .series = {},
              .equal_axes = false};
    std::vector<std::vector<Eigen::Index>> members;
    for (std::size_t i = 0; i < count; ++i) {
        const std::string value = label_values.empty() ? "" : label_values[i];
        const auto found = std::find_if(plot.series.begin(), plot.series.end(),
                                        [&](const Series& s) { return s.name == value; });
        const auto s = to_size(found - plot.series.begin());
        if (found == plot.series.end()) {
            plot.series.push_back({.name = value, .points = {}, .tips = {}, .curve = false});
            members.emplace_back();
        }
        members[s].push_back(static_cast<Eigen::Index>(i));
        plot.series[s].tips.push_back(names[i]);
    }
    for (std::size_t s = 0; s < members.size(); ++s)
        plot.series[s].points = scores(members[s], std::vector<int>{mode_x, mode_y});
    return plot;
}

} // namespace shape
