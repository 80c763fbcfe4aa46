// SPDX-License-Identifier: MIT

#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace shape {

/// What of a model stands on its page; the page itself is built by tools/explore.
struct Page
{
    std::string title;
    std::vector<std::pair<std::string, std::string>> facts; ///< Name and value.
    std::string pictures; ///< An SVG document, for browsers that draw no meshes; may be empty.
    std::vector<std::string> drawings;           ///< SVG documents.
    std::vector<std::vector<std::string>> table; ///< The first row is its head; may be empty.
    std::string model;                ///< JSON: what the page's program knows of the model.
    std::vector<unsigned char> block; ///< The model as that program decodes it.
};

/// Fills a page: one HTML document that needs no other file and no network.
/// @param frame  With the marks <!--shape:title-->, <!--shape:pictures-->, <!--shape:tables-->
///     and <!--shape:data-->, in this order.
/// @throws InvalidInput if a mark is missing.
[[nodiscard]] std::string page_html(const Page& page, std::string_view frame);

} // namespace shape
