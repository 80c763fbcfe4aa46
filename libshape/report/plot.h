// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "libshape/linalg/dense.h"
#include "libshape/report/svg.h"

namespace shape {

/// One set of points, or one curve, of a plot.
struct Series
{
    std::string name;              ///< For the legend; empty: not listed.
    Eigen::MatrixX2d points;       ///< n by 2; a point that is not finite is left out.
    std::vector<std::string> tips; ///< Empty, or one per point.
    bool curve = false;            ///< Joined by a line, without marks.
};

struct Plot
{
    std::string title; ///< May be empty.
    std::string x_label;
    std::string y_label;
    std::vector<Series> series; ///< The i-th in category_colour(i) and the i-th marker.
    bool equal_axes = false;    ///< A unit is as long in x as in y.
};

/// A place in an SVG document [px].
struct Box
{
    double x = 0.0;
    double y = 0.0;
    double width = 640.0;
    double height = 480.0;
};

/// Draws a plot into a box: axes with round ticks, a faint grid, a legend if two series have names.
/// @throws InvalidInput if a series has tips, but not one per point.
void draw_plot(Svg& svg, const Box& box, const Plot& plot);

/// The plot as a document of its own.
[[nodiscard]] std::string plot_svg(const Plot& plot, double width = 640.0, double height = 480.0);

/// Round numbers (1, 2 or 5 times a power of ten apart), about `wanted` of them, the first not above
/// low and the last not below high.
/// @param low  Finite, <= high. Ends as good as equal are widened.
[[nodiscard]] std::vector<double> round_ticks(double low, double high, int wanted = 6);

/// The scores of meshes along two modes, one series a label value in the order of first appearance.
///
/// @param scores  N by K.
/// @param label_values  N, or empty: one series.
/// @param explained  Shares of the variance in [0, 1] for the axes, at most K; may be empty.
/// @param mode_x, mode_y  Indices in [0, K).
/// @throws InvalidInput if a size or an index does not fit.
[[nodiscard]] Plot score_plot(const RowMatrix& scores, const std::vector<std::string>& names,
                              const std::vector<std::string>& label_values,
                              const Eigen::VectorXd& explained, int mode_x = 0, int mode_y = 1);

} // namespace shape
