// SPDX-License-Identifier: MIT

#include "libshape/report/score_plot.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <optional>
#include <set>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/to_size.h"
#include "libshape/report/colour_map.h"

namespace shape {
using namespace internal;
namespace {

constexpr Colour without_group{150, 150, 150};
constexpr std::size_t most_categories_of_numbers = 6;

using Members = std::vector<Eigen::Index>;

/// The finite number that the whole text spells.
std::optional<double> number_of(const std::string& text)
{
    double number = 0.0;
    const auto [rest, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (error != std::errc() || rest != text.data() + text.size() || !std::isfinite(number))
        return {};
    return number;
}

/// The values as numbers, NaN where there is none; nothing if they are categories.
std::optional<Eigen::VectorXd> on_a_scale(const std::vector<std::string>& values)
{
    Eigen::VectorXd numbers(static_cast<Eigen::Index>(values.size()));
    std::set<double> different;
    for (std::size_t i = 0; i < values.size(); ++i) {
        const std::optional<double> number = number_of(values[i]);
        if (!number && !values[i].empty())
            return {};
        numbers[static_cast<Eigen::Index>(i)] =
            number.value_or(std::numeric_limits<double>::quiet_NaN());
        if (number)
            different.insert(*number);
    }
    if (different.size() <= most_categories_of_numbers)
        return {};
    return numbers;
}

/// A label value, or several that share a series.
struct Category
{
    std::string name;
    Members members;
    bool is_group = true; ///< Not the rest, nor those without a value.
};

/// Label values in the order of their first appearance.
std::vector<Category> categories_of(const std::vector<std::string>& values)
{
    std::vector<Category> all;
    std::map<std::string, std::size_t> known;
    for (std::size_t i = 0; i < values.size(); ++i) {
        const auto [entry, is_new] = known.try_emplace(values[i], all.size());
        if (is_new)
            all.push_back({values[i], {}, !values[i].empty()});
        all[entry->second].members.push_back(static_cast<Eigen::Index>(i));
    }
    return all;
}

/// Puts all but the largest groups together, at the end; those without a value stay apart.
std::vector<Category> folded(std::vector<Category> all)
{
    std::vector<std::size_t> sizes;
    for (const Category& category : all)
        if (category.is_group)
            sizes.push_back(category.members.size());
    if (sizes.size() <= most_plot_groups)
        return all;
    std::ranges::sort(sizes, std::greater());
    const std::size_t least = sizes[most_plot_groups - 2];
    auto room = to_size(std::count(sizes.begin(), sizes.begin() + most_plot_groups - 1, least));
    std::vector<Category> kept;
    Category rest{{}, {}, false};
    std::size_t others = 0;
    for (Category& category : all) {
        const std::size_t size = category.members.size();
        if (!category.is_group || size > least || (size == least && room > 0)) {
            room -= category.is_group && size == least ? 1 : 0;
            kept.push_back(std::move(category));
            continue;
        }
        ++others;
        rest.members.insert(rest.members.end(), category.members.begin(), category.members.end());
    }
    rest.name = join(others, " others");
    kept.push_back(std::move(rest));
    return kept;
}

/// Twice the area of the triangle, > 0 if it runs counter-clockwise.
double turn(const Eigen::RowVector2d& a, const Eigen::RowVector2d& b, const Eigen::RowVector2d& c)
{
    return (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
}

/// The corners of the convex hull, the first one at the end again (Andrew 1979).
Eigen::MatrixX2d hull(const Eigen::MatrixX2d& points)
{
    std::vector<Eigen::RowVector2d> sorted(points.rowwise().begin(), points.rowwise().end());
    const auto before = [](const auto& a, const auto& b) {
        return a.x() < b.x() || (a.x() == b.x() && a.y() < b.y());
    };
    std::sort(sorted.begin(), sorted.end(), before);
    std::vector<Eigen::RowVector2d> corners;
    for (const bool is_lower : {true, false}) {
        const std::size_t start = corners.size();
        for (const Eigen::RowVector2d& point : sorted) {
            while (corners.size() >= start + 2 &&
                   turn(corners[corners.size() - 2], corners.back(), point) <= 0.0)
                corners.pop_back();
            corners.push_back(point);
        }
        corners.pop_back(); // the other chain starts there
        if (is_lower)
            std::reverse(sorted.begin(), sorted.end());
    }
    corners.push_back(corners.front());
    Eigen::MatrixX2d closed(static_cast<Eigen::Index>(corners.size()), 2);
    for (std::size_t i = 0; i < corners.size(); ++i)
        closed.row(static_cast<Eigen::Index>(i)) = corners[i];
    return closed;
}

Eigen::MatrixX2d ellipse(const Eigen::MatrixX2d& points)
{
    constexpr int corners = 72;
    constexpr double square = 5.991464547107979; // 95 % of chi-square with two degrees of freedom
    const Eigen::RowVector2d mean = points.colwise().mean();
    const Eigen::MatrixX2d centred = points.rowwise() - mean;
    const Eigen::Matrix2d covariance =
        centred.transpose() * centred / static_cast<double>(points.rows() - 1);
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(covariance);
    const Eigen::Matrix2d half =
        axes.eigenvectors() * (square * axes.eigenvalues().cwiseMax(0.0)).cwiseSqrt().asDiagonal();
    Eigen::MatrixX2d closed(corners + 1, 2);
    for (int i = 0; i <= corners; ++i) {
        const double angle = 2.0 * std::numbers::pi * (i % corners) / corners;
        closed.row(i) =
            mean + (half * Eigen::Vector2d(std::cos(angle), std::sin(angle))).transpose();
    }
    return closed;
}

Series series_of(const Category& category, const RowMatrix& shown,
                 const std::vector<std::string>& names, const std::vector<std::string>& values)
{
    Series series{.name = category.name,
                  .points = shown(category.members, Eigen::all),
                  .tips = {},
                  .curve = false};
    for (const Eigen::Index i : category.members) {
        const auto mesh = to_size(i);
        const bool is_folded = !category.is_group && !values.empty() && !values[mesh].empty();
        series.tips.push_back(is_folded ? join(names[mesh], " (", values[mesh], ")") : names[mesh]);
    }
    if (!category.is_group && !values.empty())
        series.colour = without_group;
    if (series.name.empty() && !values.empty())
        series.name = "no value";
    return series;
}

/// Curves around the groups, in their colours.
void add_outlines(Plot& plot, const std::vector<Category>& categories, GroupOutline outline)
{
    for (std::size_t s = 0; s < categories.size(); ++s) {
        const Eigen::MatrixX2d points = plot.series[s].points;
        if (!categories[s].is_group || points.rows() < 3)
            continue;
        plot.series.push_back(
            {.name = {},
             .points = outline == GroupOutline::Hull ? hull(points) : ellipse(points),
             .tips = {},
             .curve = true,
             .colour = category_colour(s)});
    }
}

} // namespace

Plot score_plot(const RowMatrix& scores, const std::vector<std::string>& names,
                const std::vector<std::string>& label_values, const Eigen::VectorXd& explained,
                const ScorePlotOptions& options)
{
    const auto count = to_size(scores.rows());
    if (names.size() != count || (!label_values.empty() && label_values.size() != count))
        throw InvalidInput(join("scores has ", count, " rows, but there are ", names.size(),
                                " names and ", label_values.size(), " label values"));
    const int mode_x = options.mode_x;
    const int mode_y = options.mode_y;
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
              .equal_axes = options.equal_axes,
              .point_names = options.names};
    const RowMatrix shown = scores(Eigen::all, std::vector<int>{mode_x, mode_y});
    if (const auto numbers = on_a_scale(label_values)) {
        plot.scale_label = options.label_name;
        plot.series.push_back(
            {.name = {}, .points = shown, .tips = names, .curve = false, .values = *numbers});
        return plot;
    }
    std::vector<Category> categories = folded(
        categories_of(label_values.empty() ? std::vector<std::string>(count) : label_values));
    for (const Category& category : categories)
        plot.series.push_back(series_of(category, shown, names, label_values));
    if (options.outline != GroupOutline::None && !label_values.empty())
        add_outlines(plot, categories, options.outline);
    return plot;
}

} // namespace shape
