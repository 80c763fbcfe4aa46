// SPDX-License-Identifier: MIT

#include <algorithm>
#include <array>
#include <vector>

#include "libshape/base/format.h"
#include "libshape/io/file/line_reader.h"
#include "libshape/io/mesh_builder.h"
#include "libshape/io/mesh_formats.h"

namespace shape::internal {
namespace {

/// Statements that add nothing to the triangles. `mtllib` is never followed.
constexpr std::array<std::string_view, 20> ignored = {
    "g",   "o",    "s",   "usemtl", "mtllib", "usemap",    "maplib",
    "l",   "p",    "vp",  "mg",     "bevel",  "c_interp",  "d_interp",
    "lod", "call", "csh", "ctech",  "stech",  "shadow_obj"};

/// Numbers of v, vt and vn statements so far.
struct ElementCounts
{
    std::int64_t v = 0;
    std::int64_t vt = 0;
    std::int64_t vn = 0;
};

/// The index from 0 of an OBJ reference: 1 is the first element so far, -1 the last.
std::int64_t resolve(const LineReader& reader, std::string_view text, std::int64_t count,
                     std::string_view what)
{
    const std::optional<std::int64_t> index = spelled_integer(text);
    if (!index)
        reader.fail(join(what, " index is ", in_quotes(text), ", must be an integer"));
    if (*index == 0 || *index > count || *index < -count)
        reader.fail(join(what, " index is ", *index, ", must be in [1, ", count, "] or [-", count,
                         ", -1]: there are ", count, " before this line"));
    return *index > 0 ? *index - 1 : count + *index;
}

/// The vertex of a corner `v`, `v/vt`, `v//vn` or `v/vt/vn`; the other references are checked only.
std::int64_t parse_corner(const LineReader& reader, std::string_view text,
                          const ElementCounts& counts)
{
    const std::size_t slash = text.find('/');
    const std::int64_t vertex = resolve(reader, text.substr(0, slash), counts.v, "vertex");
    if (slash == std::string_view::npos)
        return vertex;
    const std::string_view tail = text.substr(slash + 1);
    const std::size_t second = tail.find('/');
    const std::string_view texture = tail.substr(0, second);
    if (second == std::string_view::npos || !texture.empty())
        (void)resolve(reader, texture, counts.vt, "texture");
    if (second != std::string_view::npos)
        (void)resolve(reader, tail.substr(second + 1), counts.vn, "normal");
    return vertex;
}

/// Between `least` and `most` numbers up to the end of the line; returns how many.
int parse_numbers(LineReader& reader, std::span<double> numbers, int least)
{
    int count = 0;
    for (double& number : numbers) {
        const std::string_view text = reader.token();
        if (text.empty())
            break;
        const std::optional<double> value = spelled_number(text);
        if (!value)
            reader.fail(
                join("coordinate ", count, " is ", in_quotes(text), ", must be a finite number"));
        number = *value;
        ++count;
    }
    if (count < least)
        reader.fail(join("has ", count, " coordinates, must have at least ", least));
    reader.finish_line();
    return count;
}

} // namespace

NamedMesh parse_obj(std::string_view content, const std::filesystem::path& path,
                    const MeshReadOptions& options)
{
    LineReader reader(content, path.string(), '#');
    MeshBuilder mesh(path, options, [&](std::string_view rule) { reader.fail(rule); });
    ElementCounts counts;
    std::vector<std::int64_t> corners;
    std::array<double, 7> numbers{};
    while (reader.next_line()) {
        if (reader.line().ends_with('\\'))
            reader.fail("is continued with a backslash; write the statement on one line");
        const std::string_view keyword = reader.token();
        if (keyword == "v") { // x y z, then w, or r g b, or w r g b
            const int count = parse_numbers(reader, numbers, 3);
            if (count == 5)
                reader.fail("has 5 coordinates, must have 3, 4 (with w), 6 or 7 (with a colour)");
            if ((count == 4 || count == 7) && numbers[3] != 1.0)
                reader.fail(join("has the weight ", numbers[3], "; only 1 is read"));
            mesh.add_vertex(numbers[0], numbers[1], numbers[2]);
            ++counts.v;
        } else if (keyword == "f") {
            corners.clear();
            for (std::string_view text = reader.token(); !text.empty(); text = reader.token()) {
                if (std::ssize(corners) == MeshBuilder::corner_limit)
                    reader.fail(join("has more than ", MeshBuilder::corner_limit, " corners"));
                corners.push_back(parse_corner(reader, text, counts));
            }
            mesh.add_polygon(corners);
        } else if (keyword == "vt") {
            (void)parse_numbers(reader, std::span(numbers).first(3), 1);
            ++counts.vt;
        } else if (keyword == "vn") {
            (void)parse_numbers(reader, std::span(numbers).first(3), 3);
            ++counts.vn;
        } else if (std::find(ignored.begin(), ignored.end(), keyword) == ignored.end()) {
            reader.fail(join("unknown statement ", in_quotes(keyword), "; is this an OBJ file?"));
        }
    }
    return mesh.finish();
}

std::string print_obj(const Points& points, const Faces& faces)
{
    std::string text;
    text.reserve(static_cast<std::size_t>(points.rows() * 64 + faces.rows() * 24));
    for (const auto& row : points.rowwise())
        append_line(text, "v", row);
    for (const auto& row : faces.rowwise())
        append_line(text, "f", row.array() + 1);
    return text;
}

} // namespace shape::internal
