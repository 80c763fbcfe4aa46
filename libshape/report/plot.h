// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "libshape/report/svg.h"

namespace shape {

/// One set of points, or one curve, of a plot.
struct Series
{
    std::string name;              ///< For the legend; empty: not listed.
    Eigen::MatrixX2d points;       ///< n by 2; a point that is not finite is left out.
    std::vector<std::string> tips; ///< Empty, or one per point.
    bool curve = false;            ///< Joined by a line, without marks.
    Eigen::VectorXd values =
        {}; ///< Empty, or one per point: its place on a scale of colours, which
            ///< is drawn beside the plot; grey if it is not finite.
    Eigen::VectorXd deviations = {};   ///< Empty, or one per point, >= 0: a bar as far up and down.
    std::optional<Colour> colour = {}; ///< In the place of category_colour(i).
};

struct Plot
{
    std::string title; ///< May be empty.
    std::string x_label;
    std::string y_label;
    std::vector<Series> series;   ///< The i-th in category_colour(i) and the i-th marker.
    bool equal_axes = false;      ///< A unit is as long in x as in y.
    bool point_names = false;     ///< Tips stand beside their points where there is room.
    std::string scale_label = {}; ///< Of the scale of colours.
};

/// A place in an SVG document [px].
struct Box
{
    double x = 0.0;
    double y = 0.0;
    double width = 640.0;
    double height = 480.0;
};

/// Draws a plot into a box: axes with round ticks, a faint grid, a legend if two series have names, a
/// scale of colours if a series has values.
/// @throws InvalidInput if a series has tips, values or deviations, but not one per point.
void draw_plot(Svg& svg, const Box& box, const Plot& plot);

/// The plot as a document of its own.
[[nodiscard]] std::string plot_svg(const Plot& plot, double width = 640.0, double height = 480.0);

/// Round numbers (1, 2 or 5 times a power of ten apart), about `wanted` of them, the first not above
/// low and the last not below high.
/// @param low  Finite, <= high. Ends as good as equal are widened.
[[nodiscard]] std::vector<double> round_ticks(double low, double high, int wanted = 6);

} // namespace shape
