// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <string>
#include <string_view>
#include <vector>

#include "libshape/report/image.h"

namespace shape {

/// Escapes &, <, >, " and ' for XML; drops control characters that XML forbids.
[[nodiscard]] std::string escape_xml(std::string_view text);

/// About how wide a text is drawn [px]; the font is not known here.
[[nodiscard]] double text_width(std::string_view text, double size);

/// Where a text is pinned.
enum class TextAnchor
{
    Start,
    Middle,
    End,
};

struct TextStyle
{
    double size = 12.0; ///< [px]
    TextAnchor anchor = TextAnchor::Start;
    Colour colour{60, 60, 60};
    bool bold = false;
    double turn = 0.0; ///< Clockwise about the pin [deg].
};

/// How a point of a plot is marked.
enum class Marker
{
    Circle,
    Square,
    Triangle,
    Diamond,
};

/// An SVG document in pixels, x right, y down. Same calls, same bytes.
class Svg
{
public:
    Svg(double width, double height); ///< An empty document [px]; so are all lengths below.

    void rectangle(double x, double y, double width, double height, Colour fill); ///< Without rim.
    void line(double x0, double y0, double x1, double y1, Colour colour, double width = 1.0);
    /// @param points  n by 2.
    void polyline(const Eigen::MatrixX2d& points, Colour colour, double width = 1.5);
    /// @param tip  Shown when the pointer rests on the mark; none if empty.
    void marker(Marker marker, double x, double y, double size, Colour fill,
                std::string_view tip = {});
    void text(double x, double y, std::string_view text, const TextStyle& style = {});
    /// Embeds a raster image as PNG.
    void image(double x, double y, double width, double height, const Image& image);

    /// The whole document.
    [[nodiscard]] std::string document() const;

private:
    double width_;
    double height_;
    std::string body_;
};

} // namespace shape
