// SPDX-License-Identifier: MIT

#include <algorithm>
#include <string>
#include <vector>

#include "libshape/base/counted.h"
#include "libshape/base/format.h"
#include "libshape/base/to_size.h"
#include "libshape/io/file/line_reader.h"
#include "libshape/io/mesh_builder.h"
#include "libshape/io/mesh_formats.h"

namespace shape::internal {
namespace {

/// Bytes of the shortest line of a vertex ("0 0 0") and of a face ("3 0 0 0"), with its line end.
constexpr std::int64_t vertex_bytes = 6;
constexpr std::int64_t face_bytes = 8;

std::int64_t parse_count(LineReader& reader, std::string_view what)
{
    const std::int64_t count = reader.integer(what);
    if (count < 0)
        reader.fail(join(what, " is ", count, ", must be at least 0"));
    return count;
}

void next_line(LineReader& reader, std::string_view what, std::int64_t index, std::int64_t count)
{
    if (!reader.next_line())
        reader.fail(join("the file ends before ", what, " ", index, " of ", count));
}

/// What a header line declares, [ST][C][N]OFF: numbers that follow the coordinates of every vertex.
struct Variant
{
    std::int64_t least_extras = 0;
    std::int64_t most_extras = 0;
    /// Glued to the keyword ("OFF490 518 0"), as ModelNet has it, or without one, as Geomview takes it.
    std::string_view counts;
};

Variant parse_variant(const LineReader& reader, std::string_view word)
{
    Variant variant;
    if (spelled_integer(word))
        return {.counts = word};
    std::string upper(word); // some write "off"
    std::ranges::transform(upper, upper.begin(), [](char c) {
        return c >= 'a' && c <= 'z' && c != 'n' ? static_cast<char>(c - 'a' + 'A') : c;
    });
    std::string_view rest = upper;
    const auto take = [&](std::string_view prefix, int least, int most) {
        if (!rest.starts_with(prefix))
            return;
        rest.remove_prefix(prefix.size());
        variant.least_extras += least;
        variant.most_extras += most;
    };
    take("ST", 2, 2);
    take("C", 3, 4); // with or without alpha
    take("N", 3, 3);
    if (rest.starts_with("4OFF") || rest.starts_with("4nOFF") || rest.starts_with("nOFF"))
        reader.fail(join("starts with ", in_quotes(word),
                         ": points of other dimensions; export OFF with three coordinates"));
    if (!rest.starts_with("OFF"))
        reader.fail(join("starts with ", in_quotes(word),
                         "; must start with OFF (or COFF, NOFF, STOFF); is this an OFF file?"));
    variant.counts = word.substr(word.size() - rest.size() + 3);
    return variant;
}

/// The counts stand on the header line or on the next one.
std::int64_t parse_vertex_count(LineReader& reader, std::string_view glued)
{
    if (!glued.empty()) {
        const std::optional<std::int64_t> count = spelled_integer(glued);
        if (!count || *count < 0)
            reader.fail(join("the header is 'OFF' and ", in_quotes(glued),
                             "; the vertex count must follow OFF"));
        return *count;
    }
    if (reader.line_done() && !reader.next_line())
        reader.fail("the counts are missing");
    return parse_count(reader, "vertex count");
}

void skip_extras(LineReader& reader, const Variant& variant)
{
    if (variant.most_extras == 0) {
        if (!reader.line_done())
            reader.fail(join("unexpected ", in_quotes(reader.token()),
                             " after the three coordinates; colours need the header COFF, normals "
                             "NOFF"));
        return;
    }
    std::int64_t count = 0;
    for (std::string_view text = reader.token(); !text.empty(); text = reader.token()) {
        if (!spells_a_number(text))
            reader.fail(join(in_quotes(text), " after the coordinates must be a number"));
        ++count;
    }
    if (count < variant.least_extras || count > variant.most_extras)
        reader.fail(join("has ", counted(count, "number"), " after the coordinates, must have ",
                         variant.least_extras, " to ", variant.most_extras,
                         " as the header declares"));
}

} // namespace

NamedMesh parse_off(std::string_view content, const std::filesystem::path& path,
                    const MeshReadOptions& options)
{
    LineReader reader(content, path.string(), '#');
    MeshBuilder mesh(path, options, [&](std::string_view rule) { reader.fail(rule); });
    if (!reader.next_line())
        reader.fail("there is nothing but comments");
    const Variant variant = parse_variant(reader, reader.token());
    if (reader.rest().starts_with("BINARY"))
        reader.fail("starts with 'OFF BINARY'; export OFF as text, or PLY");
    const std::int64_t vertices = parse_vertex_count(reader, variant.counts);
    const std::int64_t faces = parse_count(reader, "face count");
    if (!reader.line_done())
        (void)parse_count(reader, "edge count"); // nobody keeps it right
    reader.finish_line();
    const auto size = static_cast<std::int64_t>(content.size() - reader.offset()) + 1;
    if (vertices > size / vertex_bytes || faces > size / face_bytes ||
        vertices * vertex_bytes + faces * face_bytes > size)
        reader.fail(join(counted(vertices, "vertex", "vertices"), " and ", counted(faces, "face"),
                         " do not fit in the remaining ", counted(size - 1, "byte")));
    mesh.reserve(vertices, faces);

    for (std::int64_t v = 0; v < vertices; ++v) {
        next_line(reader, "vertex", v, vertices);
        const double x = reader.number("coordinate x");
        const double y = reader.number("coordinate y");
        const double z = reader.number("coordinate z");
        skip_extras(reader, variant);
        mesh.add_vertex(x, y, z);
    }
    std::vector<std::int64_t> corners;
    for (std::int64_t f = 0; f < faces; ++f) {
        next_line(reader, "face", f, faces);
        const std::int64_t count = reader.integer("corner count");
        if (count < 0 || count > MeshBuilder::corner_limit)
            reader.fail(join("corner count is ", count, ", must be in [3, ",
                             MeshBuilder::corner_limit, "]"));
        corners.clear();
        for (std::int64_t c = 0; c < count; ++c)
            corners.push_back(reader.integer("vertex index"));
        mesh.add_polygon(corners);
        for (std::string_view colour = reader.token(); !colour.empty(); colour = reader.token())
            if (!spells_a_number(colour))
                reader.fail(join("colour is ", in_quotes(colour), ", must be a number"));
    }
    if (reader.next_line())
        reader.fail(join("there are more lines than ", counted(vertices, "vertex", "vertices"),
                         " and ", counted(faces, "face")));
    return mesh.finish();
}

std::string print_off(const Points& points, const Faces& faces, const MeshWriteOptions&)
{
    std::string text = join("OFF\n", points.rows(), " ", faces.rows(), " 0\n");
    text.reserve(to_size(points.rows() * 64 + faces.rows() * 24));
    for (const auto& row : points.rowwise())
        append_line(text, "", row);
    for (const auto& row : faces.rowwise())
        append_line(text, "3", row);
    return text;
}

} // namespace shape::internal
