// SPDX-License-Identifier: MIT

#include "libshape/report/image.h"

#include <png.h>

#include <algorithm>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/to_size.h"

namespace shape {
using namespace internal;

std::string hex(Colour colour)
{
    const char* digits = "0123456789abcdef";
    std::string text = "#";
    for (const std::uint8_t channel : {colour.red, colour.green, colour.blue}) {
        text += digits[channel / 16];
        text += digits[channel % 16];
    }
    return text;
}

Image::Image(int w, int h, Colour fill) : width(w), height(h), pixels(to_size(w) * to_size(h), fill)
{
}

void Image::paste(const Image& other, int x, int y)
{
    for (int row = std::max(0, -y); row < std::min(other.height, height - y); ++row)
        for (int column = std::max(0, -x); column < std::min(other.width, width - x); ++column)
            at(x + column, y + row) = other.at(column, row);
}

std::string encode_png(const Image& image)
{
    if (image.pixels.empty())
        throw InvalidInput(
            join("image is ", image.width, " by ", image.height, " pixels, must not be empty"));
    static_assert(sizeof(Colour) == 3);
    png_image png{};
    png.version = PNG_IMAGE_VERSION;
    png.width = static_cast<png_uint_32>(image.width);
    png.height = static_cast<png_uint_32>(image.height);
    png.format = PNG_FORMAT_RGB;
    // libpng's bound holds for any content; the second call says what was needed.
    png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(png);
    std::string bytes(size, '\0');
    if (!png_image_write_to_memory(&png, bytes.data(), &size, 0, image.pixels.data(), 0, nullptr))
        throw NumericalError(join("libpng cannot encode the image: ", png.message));
    bytes.resize(size);
    return bytes;
}

} // namespace shape
