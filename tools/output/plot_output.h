// SPDX-License-Identifier: MIT

#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "libshape/mesh/labels.h"
#include "libshape/report/score_plot.h"

namespace CLI {
class App;
class Option;
} // namespace CLI

namespace shape::tools {

/// @throws UsageError if a picture of an option ends neither in .svg nor in .png.
void check_picture(const std::string& option, const std::filesystem::path& path);

/// Writes a drawing as it is, or as PNG of twice its pixels if the path ends so: that is done by
/// rsvg-convert (librsvg).
/// @throws FileError as write_file_atomically(), or if rsvg-convert is missing or fails.
void write_picture(const std::filesystem::path& path, const std::string& svg);

/// How plots of one point a mesh look.
struct PointPlotArguments
{
    std::string color_by;
    bool names = false;
    GroupOutline outline = GroupOutline::None;
};

/// Adds --label and --outline. --color-by is the command's own, for not all plots need it.
void add_point_plot(CLI::App& command, PointPlotArguments& arguments, CLI::Option* plot);

/// The values of the label that colours; none if none is named.
[[nodiscard]] std::vector<std::string> colouring_values(const PointPlotArguments& arguments,
                                                        const Labels& labels);

/// What the plot is drawn by.
[[nodiscard]] ScorePlotOptions score_plot_options(const PointPlotArguments& arguments);

} // namespace shape::tools
