// SPDX-License-Identifier: MIT

#include <algorithm>
#include <array>
#include <span>
#include <vector>

#include "libshape/base/format.h"
#include "libshape/base/to_size.h"
#include "libshape/io/file/line_reader.h"
#include "libshape/io/mesh_builder.h"
#include "libshape/io/mesh_formats.h"

namespace shape::internal {
namespace {

/// Statements that add nothing to the triangles: their content is not read. `mtllib` is never
/// followed.
constexpr std::array<std::string_view, 27> ignored = {
    "vt",  "vn",     "vp",     "vc",         "vw",        "g",      "o",
    "s",   "usemtl", "mtllib", "usemap",     "usemat",    "maplib", "l",
    "p",   "mg",     "bevel",  "c_interp",   "d_interp",  "lod",    "call",
    "csh", "ctech",  "stech",  "shadow_obj", "trace_obj", "refmtl"};

/// Those of them that name files or things: a backslash at their end may be part of the name.
constexpr std::array<std::string_view, 13> naming = {
    "g",      "o",    "usemtl", "mtllib",     "usemap",    "usemat", "maplib",
    "refmtl", "call", "csh",    "shadow_obj", "trace_obj", "lod"};

/// Statements of curved surfaces.
constexpr std::array<std::string_view, 17> free_form = {
    "cstype", "deg",  "bmat", "step", "curv", "curv2", "surf", "parm", "trim",
    "hole",   "scrv", "sp",   "end",  "con",  "bzp",   "bsp",  "cdc"};

bool is_among(std::string_view keyword, std::span<const std::string_view> list)
{
    return std::find(list.begin(), list.end(), keyword) != list.end();
}

bool is_statement(std::string_view keyword)
{
    return keyword.empty() || keyword.starts_with('#') || keyword == "v" || keyword == "f" ||
           is_among(keyword, ignored) || is_among(keyword, free_form);
}

/// Joins the lines that continue a statement by backslashes. After a name (`mtllib C:\models\`) a
/// backslash continues it only if what follows is not a statement of its own.
void join_lines(LineReader& reader, std::string_view keyword)
{
    const bool is_naming = is_among(keyword, naming);
    while (reader.is_continued() && !(is_naming && is_statement(reader.next_keyword())))
        reader.join_next_line();
}

/// The index from 0 of an OBJ reference: 1 is the first vertex so far, -1 the last.
std::int64_t resolve(const LineReader& reader, std::string_view text, std::int64_t count)
{
    const std::optional<std::int64_t> index = spelled_integer(text);
    if (!index)
        reader.fail(join("vertex index is ", in_quotes(text), ", ", broken_rule_of_integer(text)));
    if (*index == 0 || *index > count || *index < -count)
        reader.fail(join("vertex index is ", *index, ", must be in [1, ", count, "] or [-", count,
                         ", -1]: there are ", count, " before this line"));
    return *index > 0 ? *index - 1 : count + *index;
}

/// The vertex of a corner `v`, `v/vt`, `v//vn` or `v/vt/vn`. The references to texture and normals are
/// not followed: they may be missing, or point to data that is not there.
std::int64_t parse_corner(const LineReader& reader, std::string_view text, std::int64_t vertices)
{
    const std::size_t slash = std::min(text.find('/'), text.size());
    const std::string_view references = text.substr(slash);
    if (references.find_first_not_of("/+-0123456789") != std::string_view::npos ||
        std::count(references.begin(), references.end(), '/') > 2)
        reader.fail(join("corner is ", in_quotes(text), ", must be v, v/vt, v//vn or v/vt/vn"));
    return resolve(reader, text.substr(0, slash), vertices);
}

/// x, y and z; then any numbers (a colour, or the weight 1) that are not kept.
std::array<double, 3> parse_vertex(LineReader& reader)
{
    std::array<double, 3> point{};
    for (std::size_t i = 0; i < point.size(); ++i) {
        const std::string_view text = reader.token();
        if (text.empty())
            reader.fail(join("has ", i, " coordinates, must have at least 3"));
        const std::optional<double> value = spelled_number(text);
        if (!value)
            reader.fail(
                join("coordinate ", i, " is ", in_quotes(text), ", must be a finite number",
                     text.find(',') == std::string_view::npos
                         ? ""
                         : " with a decimal point (export with the language set to English)"));
        point[i] = *value;
    }
    const std::string_view fourth = reader.token();
    bool is_weight = !fourth.empty() && reader.line_done();
    for (std::string_view text = fourth; !text.empty(); text = reader.token())
        if (!spells_a_number(text))
            reader.fail(
                join("coordinates are followed by ", in_quotes(text), ", must be numbers alone"));
    if (is_weight && spelled_number(fourth) != 1.0)
        reader.fail(
            join("has the weight ", fourth,
                 ", of which programs make different things; only 1 is read. Export without "
                 "weights (x y z alone), or, if it is no weight, take the fourth number away"));
    return point;
}

} // namespace

NamedMesh parse_obj(std::string_view content, const std::filesystem::path& path,
                    const MeshReadOptions& options)
{
    LineReader reader(content, path.string(), '#');
    MeshBuilder mesh(path, options, [&](std::string_view rule) { reader.fail(rule); });
    std::vector<std::int64_t> corners;
    while (reader.next_line()) {
        const std::string_view keyword = reader.token();
        join_lines(reader, keyword);
        if (keyword == "v") {
            const auto [x, y, z] = parse_vertex(reader);
            mesh.add_vertex(x, y, z);
        } else if (keyword == "f") {
            corners.clear();
            for (std::string_view text = reader.token(); !text.empty(); text = reader.token()) {
                if (std::ssize(corners) == MeshBuilder::corner_limit)
                    reader.fail(join("has more than ", MeshBuilder::corner_limit, " corners"));
                corners.push_back(parse_corner(reader, text, mesh.vertex_count()));
            }
            mesh.add_polygon(corners);
        } else if (is_among(keyword, free_form)) {
            reader.fail(join("statement ", in_quotes(keyword),
                             " is of a curved surface; export it as polygons"));
        } else if (!is_among(keyword, ignored)) {
            reader.fail(join("unknown statement ", in_quotes(keyword), "; is this an OBJ file?"));
        }
    }
    return mesh.finish();
}

std::string print_obj(const Points& points, const Faces& faces, const MeshWriteOptions& options)
{
    if (options.obj_template != nullptr)
        return print_obj_template(*options.obj_template, points);
    std::string text;
    text.reserve(to_size(points.rows() * 64 + faces.rows() * 24));
    for (const auto& row : points.rowwise())
        append_line(text, "v", row);
    for (const auto& row : faces.rowwise())
        append_line(text, "f", row.array() + 1);
    return text;
}

} // namespace shape::internal
