// SPDX-License-Identifier: MIT

#include "libshape/report/page.h"

#include <algorithm>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/report/base64.h"
#include "libshape/report/svg.h"

namespace shape {
using namespace internal;
namespace {

std::string facts_html(const std::vector<std::pair<std::string, std::string>>& facts)
{
    std::string html = "<dl>\n";
    for (const auto& [name, value] : facts)
        html += join("<dt>", escape_xml(name), "</dt><dd>", escape_xml(value), "</dd>\n");
    return html + "</dl>\n";
}

std::string table_html(const std::vector<std::vector<std::string>>& table)
{
    std::string html =
        "<div class=\"wide\" tabindex=\"0\" role=\"region\" aria-label=\"Modes\"><table>\n";
    for (std::size_t r = 0; r < table.size(); ++r) {
        html += r == 0 ? "<thead><tr>" : "<tr>";
        for (std::size_t c = 0; c < table[r].size(); ++c) {
            const std::string_view tag = r == 0   ? "th scope=\"col\""
                                         : c == 0 ? "th scope=\"row\""
                                                  : "td";
            html += join("<", tag, ">", escape_xml(table[r][c]), "</", tag.substr(0, 2), ">");
        }
        html += r == 0 ? "</tr></thead>\n" : "</tr>\n";
    }
    return html + "</table></div>\n";
}

std::string tables_html(const Page& page)
{
    std::string html = facts_html(page.facts) + "<div class=\"drawings\">\n";
    for (const std::string& drawing : page.drawings)
        html += drawing;
    html += "</div>\n";
    return page.table.empty() ? html : html + table_html(page.table);
}

/// No text in it ends a script.
std::string script_json(std::string json)
{
    for (std::size_t at = 0; (at = json.find('<', at)) != std::string::npos;)
        json.replace(at, 1, "\\u003c");
    return json;
}

/// Lines of base64, each of whole triples of bytes: browsers decode texts of some megabytes best.
std::string base64_lines(const std::vector<unsigned char>& bytes)
{
    constexpr std::size_t line = 3 << 20;
    const std::string_view all(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    std::string text;
    for (std::size_t at = 0; at < all.size(); at += line)
        text += base64(all.substr(at, line)) + "\n";
    return text;
}

} // namespace

std::string page_html(const Page& page, std::string_view frame)
{
    const std::pair<std::string_view, std::string> parts[] = {
        {"<!--shape:title-->", join("<title>", escape_xml(page.title), "</title>")},
        {"<!--shape:pictures-->", join("<div class=\"drawings\">", page.pictures, "</div>")},
        {"<!--shape:tables-->", tables_html(page)},
        {"<!--shape:data-->",
         join("<script type=\"application/json\" id=\"facts\">", script_json(page.model),
              "</script>\n<script type=\"text/plain\" id=\"block\">", base64_lines(page.block),
              "</script>")}};
    std::string html;
    for (const auto& [mark, text] : parts) {
        const std::size_t at = frame.find(mark);
        if (at == std::string_view::npos)
            throw InvalidInput(join("page: the frame has no ", mark));
        html.append(frame.substr(0, at));
        html += text;
        frame.remove_prefix(at + mark.size());
    }
    return html.append(frame);
}

} // namespace shape
