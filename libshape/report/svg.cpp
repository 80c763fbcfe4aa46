// SPDX-License-Identifier: MIT

#include "libshape/report/svg.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include "libshape/base/format.h"
#include "libshape/report/base64.h"

namespace shape {
using namespace internal;
namespace {

/// At most two decimals, no exponent.
std::string number(double value)
{
    const double rounded = std::round(100.0 * value) / 100.0;
    std::array<char, 400> digits{};
    const auto end = std::to_chars(digits.data(), digits.data() + digits.size(),
                                   rounded == 0.0 ? 0.0 : rounded, std::chars_format::fixed);
    return {digits.data(), end.ptr};
}

/// Outlines of about the same area, in units of the size of a circle's radius.
std::string outline(Marker marker, double x, double y, double r)
{
    const auto move = [&](double dx, double dy) {
        return join(number(x + dx), ",", number(y + dy));
    };
    switch (marker) {
        case Marker::Square:
            r *= 0.89;
            return join("M", move(-r, -r), "L", move(r, -r), "L", move(r, r), "L", move(-r, r),
                        "Z");
        case Marker::Triangle:
            r *= 1.35;
            return join("M", move(0.0, -r), "L", move(0.866 * r, 0.5 * r), "L",
                        move(-0.866 * r, 0.5 * r), "Z");
        case Marker::Diamond:
            r *= 1.25;
            return join("M", move(0.0, -r), "L", move(r, 0.0), "L", move(0.0, r), "L",
                        move(-r, 0.0), "Z");
        case Marker::Circle:
            break;
    }
    const std::string radius = number(r);
    const std::string arc = join("A", radius, " ", radius, " 0 1 0 ");
    return join("M", move(-r, 0.0), arc, move(r, 0.0), arc, move(-r, 0.0), "Z");
}

} // namespace

std::string escape_xml(std::string_view text)
{
    std::string result;
    for (const char c : text) {
        switch (c) {
            case '&':
                result += "&amp;";
                break;
            case '<':
                result += "&lt;";
                break;
            case '>':
                result += "&gt;";
                break;
            case '"':
                result += "&quot;";
                break;
            case '\'':
                result += "&#39;";
                break;
            default:
                if (static_cast<unsigned char>(c) >= 0x20 || c == '\t' || c == '\n')
                    result += c;
        }
    }
    return result;
}

Svg::Svg(double width, double height) : width_(width), height_(height) {}

void Svg::rectangle(double x, double y, double width, double height, Colour fill)
{
    body_ += join("<rect x=\"", number(x), "\" y=\"", number(y), "\" width=\"", number(width),
                  "\" height=\"", number(height), "\" fill=\"", hex(fill), "\"/>\n");
}

void Svg::line(double x0, double y0, double x1, double y1, Colour colour, double width)
{
    body_ += join("<line x1=\"", number(x0), "\" y1=\"", number(y0), "\" x2=\"", number(x1),
                  "\" y2=\"", number(y1), "\" stroke=\"", hex(colour), "\" stroke-width=\"",
                  number(width), "\"/>\n");
}

void Svg::polyline(const Eigen::MatrixX2d& points, Colour colour, double width)
{
    body_ += "<polyline fill=\"none\" points=\"";
    for (Eigen::Index i = 0; i < points.rows(); ++i)
        body_ += join(i > 0 ? " " : "", number(points(i, 0)), ",", number(points(i, 1)));
    body_ += join("\" stroke=\"", hex(colour), "\" stroke-width=\"", number(width),
                  "\" stroke-linejoin=\"round\"/>\n");
}

double text_width(std::string_view text, double size)
{
    const auto starts_letter = [](char c) {
        return (static_cast<unsigned char>(c) & 0xc0) != 0x80;
    };
    const auto letters = std::count_if(text.begin(), text.end(), starts_letter); // of UTF-8
    return 0.56 * size * static_cast<double>(letters);
}

void Svg::marker(Marker marker, double x, double y, double size, Colour fill, std::string_view tip)
{
    body_ += join("<path d=\"", outline(marker, x, y, 0.5 * size), "\" fill=\"", hex(fill),
                  "\" fill-opacity=\"0.8\" stroke=\"#ffffff\" stroke-width=\"0.6\"");
    body_ += tip.empty() ? "/>\n" : join("><title>", escape_xml(tip), "</title></path>\n");
}

void Svg::text(double x, double y, std::string_view text, const TextStyle& style)
{
    const char* anchor = style.anchor == TextAnchor::Start    ? "start"
                         : style.anchor == TextAnchor::Middle ? "middle"
                                                              : "end";
    body_ +=
        join("<text x=\"", number(x), "\" y=\"", number(y), "\" font-size=\"", number(style.size),
             "\" text-anchor=\"", anchor, "\" fill=\"", hex(style.colour), "\"");
    if (style.bold)
        body_ += " font-weight=\"bold\"";
    if (style.turn != 0.0)
        body_ +=
            join(" transform=\"rotate(", number(style.turn), " ", number(x), " ", number(y), ")\"");
    body_ += join(">", escape_xml(text), "</text>\n");
}

void Svg::image(double x, double y, double width, double height, const Image& image)
{
    body_ += join("<image x=\"", number(x), "\" y=\"", number(y), "\" width=\"", number(width),
                  "\" height=\"", number(height), "\" href=\"data:image/png;base64,",
                  base64(encode_png(image)), "\"/>\n");
}

std::string Svg::document() const
{
    return join("<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"", number(width_),
                "\" height=\"", number(height_), "\" viewBox=\"0 0 ", number(width_), " ",
                number(height_), "\" font-family=\"Helvetica, Arial, sans-serif\">\n", body_,
                "</svg>\n");
}

} // namespace shape
