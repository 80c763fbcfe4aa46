// SPDX-License-Identifier: MIT

#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace shape {

/// A colour, sRGB, 0 to 255 a channel.
struct Colour
{
    std::uint8_t red = 0;
    std::uint8_t green = 0;
    std::uint8_t blue = 0;

    bool operator==(const Colour&) const = default;
};

/// "#rrggbb".
[[nodiscard]] std::string hex(Colour colour);

/// A raster image, rows from the top.
struct Image
{
    int width = 0;              ///< [pixel]
    int height = 0;             ///< [pixel]
    std::vector<Colour> pixels; ///< Row by row from the top, from left to right.

    Image() = default;
    Image(int w, int h, Colour fill); ///< All pixels of one colour.

    [[nodiscard]] Colour& at(int x, int y) { return pixels[index(x, y)]; }
    [[nodiscard]] const Colour& at(int x, int y) const { return pixels[index(x, y)]; }

    /// Copies another image to where its upper left corner is (x, y); what sticks out is cut off.
    void paste(const Image& other, int x, int y);

private:
    [[nodiscard]] std::size_t index(int x, int y) const
    {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
               static_cast<std::size_t>(x);
    }
};

/// The bytes of a PNG file, 8 bits a channel, by libpng.
/// @throws InvalidInput if the image is empty; NumericalError if libpng fails.
[[nodiscard]] std::string encode_png(const Image& image);

} // namespace shape
