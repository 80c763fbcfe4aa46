// SPDX-License-Identifier: MIT

#include <algorithm>
#include <limits>
#include <optional>
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

constexpr std::string_view blank_characters = " \t\v\f";

std::string_view first_token(std::string_view line)
{
    return line.substr(0, line.find_first_of(blank_characters));
}

/// @param most  Not counted further: a line of many vertices is looked at once for each.
std::int64_t count_tokens(std::string_view line,
                          std::int64_t most = std::numeric_limits<std::int64_t>::max())
{
    std::int64_t count = 0;
    while (!line.empty() && count < most) {
        ++count;
        line.remove_prefix(std::min(line.find_first_of(blank_characters), line.size()));
        line.remove_prefix(std::min(line.find_first_not_of(blank_characters), line.size()));
    }
    return count;
}

/// Counts and vertices as Geomview reads them: numbers that may run on over the lines. Nearly all files have a
/// vertex a line; where one has not, a number may as well be missing or too many. So the first such place
/// is kept, and named if the numbers do not come out even in the end.
class NumberStream
{
public:
    explicit NumberStream(LineReader& reader) : reader_(reader) {}

    double number(std::string_view what)
    {
        go_on(what);
        return reader_.number(what);
    }

    std::int64_t count(std::string_view what)
    {
        if (go_on(what) && !spelled_integer(first_token(reader_.rest())))
            fail(join(what, " is ", in_quotes(first_token(reader_.rest())), ", ",
                      broken_rule_of_integer(first_token(reader_.rest()))));
        const std::int64_t count = reader_.integer(what);
        if (count < 0)
            reader_.fail(join(what, " is ", count, ", must be at least 0"));
        return count;
    }

    /// What stands beside the geometry.
    void skip_number(std::string_view what)
    {
        go_on(what);
        if (const std::string_view text = reader_.token(); !spells_a_number(text))
            reader_.fail(join(in_quotes(text), " after the coordinates must be a number"));
    }

    /// Whether a line was not what it usually is.
    [[nodiscard]] bool run_on() const { return first_.has_value(); }

    /// Keeps the rule that this line breaks, unless the numbers come out even in the end; a word breaks it now.
    void keep_odd_end(std::string_view rule)
    {
        if (!reader_.line_done() && !spells_a_number(first_token(reader_.rest())))
            reader_.fail(rule);
        keep(rule);
    }

    /// Names the first place where numbers ran on; if there is none, the present one.
    [[noreturn]] void fail(std::string_view rule) const
    {
        if (first_)
            first_->place.fail(
                join(first_->rule, "; taken as numbers that run on over the lines, ", rule));
        reader_.fail(rule);
    }

private:
    /// Goes to the next line if this one has ended.
    bool go_on(std::string_view what)
    {
        if (!reader_.line_done())
            return false;
        keep(join(what, " is missing"));
        if (!reader_.next_line())
            fail("the file ends there");
        return true;
    }
    void keep(std::string_view rule)
    {
        if (!first_)
            first_ = {reader_, std::string(rule)};
    }

    struct Kept
    {
        LineReader place;
        std::string rule;
    };

    LineReader& reader_;
    std::optional<Kept> first_;
};

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

/// The counts stand on the header line or after it.
std::int64_t parse_vertex_count(LineReader& reader, NumberStream& numbers, std::string_view glued)
{
    if (!glued.empty()) {
        const std::optional<std::int64_t> count = spelled_integer(glued);
        if (!count && broken_rule_of_integer(glued) != broken_rule_of_integer(""))
            reader.fail(
                join("vertex count is ", in_quotes(glued), ", ", broken_rule_of_integer(glued)));
        if (!count || *count < 0)
            reader.fail(join("the header is 'OFF' and ", in_quotes(glued),
                             "; the vertex count must follow OFF"));
        return *count;
    }
    if (reader.line_done() && !reader.next_line())
        reader.fail("the counts are missing");
    return numbers.count("vertex count");
}

/// Nobody keeps the edge count right, and some leave it out.
void skip_edge_count(LineReader& reader, NumberStream& numbers)
{
    if (reader.line_done()) {
        LineReader ahead = reader;
        if (!ahead.next_line() || count_tokens(ahead.rest()) > 1 ||
            !spelled_integer(first_token(ahead.rest())))
            return;
    }
    (void)numbers.count("edge count");
    if (!reader.line_done())
        numbers.keep_odd_end(
            join("unexpected ", in_quotes(first_token(reader.rest())), " at the end of the line"));
}

struct MeshCounts
{
    std::int64_t vertices;
    std::int64_t faces;
};

MeshCounts parse_counts(LineReader& reader, NumberStream& numbers, std::string_view glued,
                        std::size_t bytes)
{
    MeshCounts counts{};
    counts.vertices = parse_vertex_count(reader, numbers, glued);
    counts.faces = numbers.count("face count");
    skip_edge_count(reader, numbers);
    const auto size = static_cast<std::int64_t>(bytes - reader.offset() + reader.rest().size()) + 1;
    if (counts.vertices > size / vertex_bytes || counts.faces > size / face_bytes ||
        counts.vertices * vertex_bytes + counts.faces * face_bytes > size)
        numbers.fail(join(counted(counts.vertices, "vertex", "vertices"), " and ",
                          counted(counts.faces, "face"), " do not fit in the remaining ",
                          counted(size - 1, "byte")));
    return counts;
}

std::string odd_end(const LineReader& reader, const Variant& variant)
{
    if (variant.most_extras == 0)
        return join("unexpected ", in_quotes(first_token(reader.rest())),
                    " after the three coordinates; colours need the header COFF, normals NOFF");
    const std::int64_t extras = count_tokens(reader.rest());
    std::string vertices; // several of them on the line, their colours all with alpha or without
    for (std::int64_t each = variant.least_extras; each <= variant.most_extras; ++each)
        if (vertices.empty() && extras > each && (extras + 3) % (each + 3) == 0)
            vertices = join(", if this is one vertex; ", (extras + 3) / (each + 3),
                            " vertices would have as many: give each a line of its own");
    return join("has ", counted(extras, "number"), " after the coordinates, must have ",
                variant.least_extras, " to ", variant.most_extras, " as the header declares",
                vertices);
}

/// Colours, normals and texture coordinates of a vertex. The rest of the line is taken for them if there are as
/// many as the header declares; else as many as Geomview reads.
void skip_extras(LineReader& reader, NumberStream& numbers, const Variant& variant)
{
    std::int64_t extras = count_tokens(reader.rest(), variant.most_extras + 1);
    if (extras < variant.least_extras || extras > variant.most_extras) {
        if (!numbers.run_on())
            numbers.keep_odd_end(odd_end(reader, variant));
        extras = variant.most_extras;
    }
    for (std::int64_t i = 0; i < extras; ++i)
        numbers.skip_number("a number after the coordinates");
}

void parse_vertices(LineReader& reader, NumberStream& numbers, const Variant& variant,
                    std::int64_t count, MeshBuilder& mesh)
{
    for (std::int64_t v = 0; v < count; ++v) {
        if (reader.line_done() && !reader.next_line())
            numbers.fail(join("the file ends before vertex ", v, " of ", count));
        const double x = numbers.number("coordinate x");
        const double y = numbers.number("coordinate y");
        const double z = numbers.number("coordinate z");
        skip_extras(reader, numbers, variant);
        mesh.add_vertex(x, y, z);
    }
}

/// Whether the rest of the line is a face and nothing more.
bool is_whole_face(std::string_view line)
{
    const std::optional<std::int64_t> corners = spelled_integer(first_token(line));
    return corners && *corners >= 3 && count_tokens(line) - 1 == *corners;
}

/// Where vertices ran on over the lines and what is no integer stands in a face, as colours of vertices under a plain OFF
/// come to do, the fault is up there.
std::int64_t face_integer(LineReader& reader, const NumberStream& numbers, std::string_view what)
{
    if (numbers.run_on() && !spelled_integer(first_token(reader.rest())))
        numbers.fail(join(what, " is ", in_quotes(first_token(reader.rest()))));
    return reader.integer(what);
}

/// Corners may run on over the lines if they end with one; colours end where the line does.
void parse_corners(LineReader& reader, const NumberStream& numbers, std::int64_t count,
                   std::vector<std::int64_t>& corners)
{
    std::optional<LineReader> begun;
    corners.clear();
    for (std::int64_t c = 0; c < count; ++c) {
        if (reader.line_done()) {
            if (!begun)
                begun = reader;
            if (!reader.next_line())
                begun->fail("vertex index is missing");
        }
        corners.push_back(face_integer(reader, numbers, "vertex index"));
    }
    if (begun && !reader.line_done())
        begun->fail("vertex index is missing");
}

void parse_faces(LineReader& reader, const NumberStream& numbers, std::int64_t count,
                 MeshBuilder& mesh)
{
    if (!reader.line_done() && (count == 0 || !is_whole_face(reader.rest())))
        numbers.fail("the last vertex does not end with its line");
    std::vector<std::int64_t> corners;
    std::optional<LineReader> doubled; // what follows a face may be its colour
    for (std::int64_t f = 0; f < count; ++f) {
        if (reader.line_done() && !reader.next_line()) {
            const std::string end = join("the file ends before face ", f, " of ", count);
            if (doubled)
                doubled->fail(
                    "two faces stand on this line, as it seems: give each a line of its "
                    "own; taken as one with a colour, " +
                    end);
            numbers.fail(end);
        }
        const std::int64_t size = face_integer(reader, numbers, "corner count");
        if (size < 0 || size > MeshBuilder::corner_limit)
            numbers.fail(join("corner count is ", size, ", must be in [3, ",
                              MeshBuilder::corner_limit, "]"));
        parse_corners(reader, numbers, size, corners);
        mesh.add_polygon(corners);
        if (!doubled && is_whole_face(reader.rest()))
            doubled = reader;
        for (std::string_view colour = reader.token(); !colour.empty(); colour = reader.token())
            if (!spells_a_number(colour))
                reader.fail(join("colour is ", in_quotes(colour), ", must be a number"));
    }
}

} // namespace

NamedMesh parse_off(std::string_view content, const std::filesystem::path& path,
                    const MeshReadOptions& options)
{
    LineReader reader(content, path.string(), '#');
    NumberStream numbers(reader);
    MeshBuilder mesh(path, options, [&](std::string_view rule) { numbers.fail(rule); });
    if (!reader.next_line())
        reader.fail("there is nothing but comments");
    const Variant variant = parse_variant(reader, reader.token());
    if (reader.rest().starts_with("BINARY"))
        reader.fail("starts with 'OFF BINARY'; export OFF as text, or PLY");
    const auto [vertices, faces] = parse_counts(reader, numbers, variant.counts, content.size());
    mesh.reserve(vertices, faces);
    parse_vertices(reader, numbers, variant, vertices, mesh);
    parse_faces(reader, numbers, faces, mesh);
    if (reader.next_line())
        numbers.fail(join("there are more lines than ", counted(vertices, "vertex", "vertices"),
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
