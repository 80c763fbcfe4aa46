// SPDX-License-Identifier: MIT

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>

#include "libshape/base/counted.h"
#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/letter_case.h"
#include "libshape/base/to_size.h"
#include "libshape/io/file/line_reader.h"
#include "libshape/io/mesh_builder.h"
#include "libshape/io/mesh_formats.h"
#include "libshape/io/vtk_values.h"

// Legacy files of VTK: lines of keywords, each followed by its numbers, as text or as bytes, the
// highest first.

namespace shape::internal {
namespace {

constexpr bool swap_bytes = std::endian::native == std::endian::little;

bool is_blank(char c)
{
    return c == ' ' || c == '\n' || c == '\r' || c == '\t' || c == '\f' || c == '\v';
}

class VtkReader
{
public:
    VtkReader(std::string_view content, std::string path)
        : content_(content), path_(std::move(path))
    {
    }

    bool is_binary = false;

    [[noreturn]] void fail(std::string_view rule) const
    {
        const auto end = content_.begin() + static_cast<std::ptrdiff_t>(offset_);
        throw InvalidInput(
            is_binary
                ? join(path_, ": byte ", offset_, ": ", rule)
                : join(path_, ": line ", 1 + std::count(content_.begin(), end, '\n'), ": ", rule));
    }

    /// What is left of the line; the next one begins behind it.
    std::string_view line()
    {
        const std::size_t end = std::min(content_.find('\n', offset_), content_.size());
        std::string_view line = content_.substr(offset_, end - offset_);
        offset_ = std::min(end + 1, content_.size());
        while (!line.empty() && is_blank(line.back()))
            line.remove_suffix(1);
        return line;
    }

    /// The next word, over ends of lines; empty at the end of the file.
    std::string_view token()
    {
        while (offset_ < content_.size() && is_blank(content_[offset_]))
            ++offset_;
        const std::size_t begin = offset_;
        while (offset_ < content_.size() && !is_blank(content_[offset_]))
            ++offset_;
        return content_.substr(begin, offset_ - begin);
    }

    std::string_view word(std::string_view what)
    {
        const std::string_view text = token();
        if (text.empty())
            fail(join("the file ends before ", what));
        return text;
    }

    /// The next word in capitals, in which keywords are compared as VTK itself does: in either case.
    std::string keyword() { return upper_case(token()); }
    std::string keyword(std::string_view what) { return upper_case(word(what)); }

    std::int64_t count(std::string_view what)
    {
        const std::string_view text = word(what);
        const std::optional<std::int64_t> value = spelled_integer(text);
        if (value && *value < 0)
            fail(join(what, " is ", in_quotes(text), ", must be an integer >= 0"));
        if (!value)
            fail(join(what, " is ", in_quotes(text), ", ", broken_rule_of_integer(text)));
        return *value;
    }

    ScalarType type() { return type(word("the type of an array")); }

    [[nodiscard]] ScalarType type(std::string_view name) const
    {
        const std::optional<ScalarType> found = legacy_vtk_type(lower_case(name));
        if (!found)
            fail(join("an array of type ", in_quotes(name), " is not read"));
        return *found;
    }

    /// take(index, bytes or null, word) for each of `count` values behind this line.
    template <class Take>
    void values(ScalarType type, std::int64_t count, const Take& take)
    {
        if (is_binary)
            (void)line();
        const auto left = static_cast<std::int64_t>(content_.size() - offset_);
        const std::int64_t least = is_binary ? size_of(type) : 2;
        if (count > (left + 1) / least)
            fail(join(counted(count, "value"), " do not fit in the remaining ",
                      counted(left, "byte")));
        for (std::int64_t i = 0; i < count; ++i)
            if (is_binary) {
                if (offset_ + to_size(least) > content_.size())
                    fail("the file ends within an array");
                take(i, content_.data() + offset_, std::string_view());
                offset_ += to_size(least);
            } else {
                take(i, nullptr, word("the end of an array"));
            }
    }

    std::vector<std::int64_t> integers(ScalarType type, std::int64_t count)
    {
        std::vector<std::int64_t> result;
        if (!is_integer(type))
            fail("indices must have an integer type");
        values(type, count, [&](std::int64_t, const char* bytes, std::string_view text) {
            const std::optional<std::int64_t> value =
                bytes != nullptr ? integer_at(bytes, type, swap_bytes) : spelled_integer(text);
            if (!value)
                fail(bytes != nullptr ? join("an index is ", unsigned_at(bytes, swap_bytes),
                                             ", which is beyond what can be counted, 2^63 - 1")
                                      : join("an index is ", in_quotes(text), ", ",
                                             broken_rule_of_integer(text)));
            result.push_back(*value);
        });
        return result;
    }

    /// Passes over an array of a field, which may hold texts and bits as well.
    void skip(std::int64_t count)
    {
        const std::string name = lower_case(word("the type of an array"));
        if (name == "string" || name == "utf8_string")
            skip_texts(count);
        else if (name == "bit" && is_binary)
            values(ScalarType::Uint8, (count + 7) / 8, ignore);
        else
            values(name == "bit" ? ScalarType::Uint8 : type(name), count, ignore);
    }

private:
    static void ignore(std::int64_t /*index*/, const char* /*bytes*/, std::string_view /*word*/) {}

    /// Texts are lines, or bytes behind their number: two bits that say of how many bytes that is, and it.
    void skip_texts(std::int64_t count)
    {
        (void)line();
        for (std::int64_t i = 0; i < count; ++i) {
            if (offset_ >= content_.size())
                fail("the file ends within an array of texts");
            if (!is_binary) {
                (void)line();
                continue;
            }
            const auto first = static_cast<unsigned char>(content_[offset_]);
            const std::size_t size = std::size_t{8} >> (first >> 6);
            if (size > content_.size() - offset_)
                fail("the file ends within an array of texts");
            std::uint64_t length = first & 0x3f;
            for (std::size_t k = 1; k < size; ++k)
                length = length << 8 | static_cast<unsigned char>(content_[offset_ + k]);
            offset_ += size;
            if (length > content_.size() - offset_)
                fail(join("a text of ", length, " bytes does not fit in the file"));
            offset_ += length;
        }
    }

    std::string_view content_;
    std::string path_;
    std::size_t offset_ = 0;
};

/// Whether cells are kept as offsets and connectivity, as since version 5.
bool parse_head(VtkReader& reader)
{
    constexpr std::string_view magic = "# vtk DataFile Version ";
    const std::string_view first = reader.line();
    if (!first.starts_with(magic))
        reader.fail("must start with '# vtk DataFile Version'; is this a legacy VTK file?");
    const std::string_view version = first.substr(magic.size());
    const std::optional<std::int64_t> major = spelled_integer(version.substr(0, version.find('.')));
    if (!major || *major < 1 || *major > 5)
        reader.fail(join("version is ", in_quotes(version), ", must be 1.0 to 5.1"));
    (void)reader.line(); // the title
    const std::string encoding = reader.keyword("ASCII or BINARY");
    if (encoding != "ASCII" && encoding != "BINARY")
        reader.fail(join("encoding is ", in_quotes(encoding), ", must be ASCII or BINARY"));
    reader.is_binary = encoding == "BINARY";
    return *major >= 5;
}

void parse_points(VtkReader& reader, MeshBuilder& mesh, bool& is_single)
{
    if (mesh.vertex_count() > 0)
        reader.fail("POINTS stands twice");
    const std::int64_t count = reader.count("the number of points");
    if (count > MeshBuilder::vertex_limit)
        mesh.reserve(count, 0); // says so
    const ScalarType type = reader.type();
    is_single = type == ScalarType::Float32;
    std::array<double, 3> point{};
    reader.values(type, 3 * count, [&](std::int64_t i, const char* bytes, std::string_view text) {
        const auto axis = to_size(i % 3);
        if (bytes != nullptr) {
            point[axis] = number_at(bytes, type, swap_bytes);
        } else {
            const std::optional<double> value = spelled_number(text);
            if (!value)
                reader.fail(join("coordinate is ", in_quotes(text), ", must be a finite number"));
            point[axis] = *value;
        }
        if (axis == 2)
            mesh.add_vertex(point[0], point[1], point[2]);
    });
}

VtkCells parse_cells(VtkReader& reader, bool has_offsets)
{
    VtkCells cells;
    const std::int64_t count = reader.count("the number of cells");
    const std::int64_t size = reader.count("the size of the cells");
    if (has_offsets) {
        if (count == 0)
            return cells;
        if (reader.keyword("OFFSETS") != "OFFSETS")
            reader.fail("OFFSETS must follow the counts");
        const ScalarType type = reader.type();
        cells.ends = reader.integers(type, count);
        if (cells.ends.front() != 0)
            reader.fail("the first of OFFSETS must be 0");
        cells.ends.erase(cells.ends.begin());
        if (reader.keyword("CONNECTIVITY") != "CONNECTIVITY")
            reader.fail("CONNECTIVITY must follow OFFSETS");
        const ScalarType corner_type = reader.type();
        cells.connectivity = reader.integers(corner_type, size);
        return cells;
    }
    const std::vector<std::int64_t> list = reader.integers(ScalarType::Int32, size);
    for (std::size_t i = 0; i < list.size(); i += 1 + to_size(list[i])) {
        if (list[i] < 0 || list[i] > std::ssize(list) - static_cast<std::int64_t>(i) - 1)
            reader.fail(join("a cell has ", list[i], " corners, which its list does not hold"));
        const auto begin = list.begin() + static_cast<std::ptrdiff_t>(i) + 1;
        cells.connectivity.insert(cells.connectivity.end(), begin, begin + list[i]);
        cells.ends.push_back(std::ssize(cells.connectivity));
    }
    if (std::ssize(cells.ends) != count)
        reader.fail(
            join("the list holds ", counted(cells.ends.size(), "cell"), ", must hold ", count));
    return cells;
}

/// Whatever stands up to the next empty line.
void skip_metadata(VtkReader& reader)
{
    (void)reader.line();
    while (!reader.line().empty()) {
    }
}

void skip_field(VtkReader& reader)
{
    (void)reader.word("the name of a field");
    const std::int64_t arrays = reader.count("the number of arrays");
    for (std::int64_t i = 0; i < arrays; ++i) {
        if (reader.word("the name of an array") == "METADATA") {
            skip_metadata(reader);
            --i;
            continue;
        }
        const std::int64_t components = reader.count("the number of components");
        const std::int64_t tuples = reader.count("the number of tuples");
        if (components > 0 && tuples > (std::int64_t{1} << 40) / components)
            reader.fail("an array of a field does not fit in the file");
        reader.skip(components * tuples);
    }
}

} // namespace

MeshFileContent parse_vtk(std::string_view content, const std::filesystem::path& path,
                          const MeshReadOptions& options)
{
    VtkReader reader(content, path.string());
    const MeshBuilder::Fail fail = [&](std::string_view rule) { reader.fail(rule); };
    MeshBuilder mesh(path, options, fail);
    const bool has_offsets = parse_head(reader);
    bool is_single = false;
    bool has_kind = false;
    for (std::string keyword = reader.keyword(); !keyword.empty(); keyword = reader.keyword()) {
        if (keyword == "DATASET") {
            const std::string kind = reader.keyword("the kind of the dataset");
            if (kind != "POLYDATA")
                reader.fail(join("the dataset is ", in_quotes(kind),
                                 ", must be POLYDATA: extract the surface first"));
            has_kind = true;
        } else if (keyword == "FIELD") {
            skip_field(reader);
        } else if (keyword == "METADATA") {
            skip_metadata(reader);
        } else if (keyword == "POINT_DATA" || keyword == "CELL_DATA") {
            break; // all geometry stands before it
        } else if (!has_kind) {
            reader.fail(join("must be 'DATASET POLYDATA', is ", in_quotes(keyword)));
        } else if (keyword == "POINTS") {
            parse_points(reader, mesh, is_single);
        } else if (keyword == "POLYGONS" || keyword == "TRIANGLE_STRIPS") {
            const bool are_strips = keyword.front() == 'T'; // the cells move on
            add_cells(mesh, parse_cells(reader, has_offsets), 0, are_strips, fail);
        } else if (keyword == "LINES" || keyword == "VERTICES") {
            (void)parse_cells(reader, has_offsets);
        } else {
            reader.fail(join("unknown keyword ", in_quotes(keyword)));
        }
    }
    return {.meshes = {mesh.finish()}, .single_precision = is_single};
}

namespace {

template <class Value>
void append_big_endian(std::string& text, Value value)
{
    auto bytes = std::bit_cast<std::array<char, sizeof(Value)>>(value);
    if constexpr (swap_bytes)
        std::reverse(bytes.begin(), bytes.end());
    text.append(bytes.data(), bytes.size());
}

/// Ends the line of a keyword or the values behind it.
void append_values(std::string& text, const auto& values, const MeshWriteOptions& options)
{
    for (const double value : values) {
        if (options.ascii) {
            if (options.single_precision)
                append_number(text, static_cast<float>(value));
            else
                append_number(text, value);
            text += ' ';
        } else if (options.single_precision) {
            append_big_endian(text, static_cast<float>(value));
        } else {
            append_big_endian(text, value);
        }
    }
    text += '\n';
}

} // namespace

std::string print_vtk(const Points& points, const Faces& faces, const MeshWriteOptions& options)
{
    check_colour_names(options, {"colours"});
    const char* const type = options.single_precision ? "float" : "double";
    std::string text =
        join("# vtk DataFile Version 3.0\nlibshape\n", options.ascii ? "ASCII" : "BINARY",
             "\nDATASET POLYDATA\nPOINTS ", points.rows(), " ", type, "\n");
    text.reserve(to_size(points.rows() * 32 + faces.rows() * 20));
    append_values(text, points.reshaped<Eigen::RowMajor>(), options);
    text += join("POLYGONS ", faces.rows(), " ", 4 * faces.rows(), "\n");
    for (const auto& face : faces.rowwise()) {
        if (options.ascii) {
            append_line(text, "3", face);
            continue;
        }
        append_big_endian(text, std::int32_t{3});
        for (const int corner : face)
            append_big_endian(text, std::int32_t{corner});
    }
    if (!options.ascii)
        text += '\n';
    if (!options.scalars.empty() || options.colours.rows() > 0)
        text += join("POINT_DATA ", points.rows(), "\n");
    for (const VertexScalar& scalar : options.scalars) {
        text += join("SCALARS ", scalar.name, " ", type, " 1\nLOOKUP_TABLE default\n");
        append_values(text, scalar.values, options);
    }
    if (options.colours.rows() > 0) {
        // As an array: COLOR_SCALARS would be another type in text than in bytes.
        text += join("FIELD FieldData 1\ncolours 3 ", options.colours.rows(), " unsigned_char\n");
        for (const std::uint8_t value : options.colours.reshaped<Eigen::RowMajor>())
            if (options.ascii)
                text += join(int{value}, " ");
            else
                text += static_cast<char>(value);
        text += '\n';
    }
    return text;
}

} // namespace shape::internal
