// SPDX-License-Identifier: MIT

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <numeric>
#include <set>
#include <vector>

#include "libshape/base/counted.h"
#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/to_size.h"
#include "libshape/io/file/input_file.h"
#include "libshape/io/file/line_reader.h"
#include "libshape/io/file/output_file.h"
#include "libshape/io/label_file.h"
#include "libshape/io/mesh_builder.h"
#include "libshape/io/mesh_formats.h"
#include "libshape/io/scalar_type.h"
#include "libshape/io/vertex_scalars.h"
#include "libshape/mesh/oddities.h"

namespace shape {
using namespace internal;
namespace {

/// Those of the format, and what some writers add to them, in the order of ScalarType.
constexpr std::array<std::array<std::string_view, 3>, 11> scalar_names = {
    {{"char", "int8", "byte"},
     {"uchar", "uint8", "ubyte"},
     {"short", "int16", "int16"},
     {"ushort", "uint16", "uint16"},
     {"int", "int32", "int32"},
     {"uint", "uint32", "uint32"},
     {"int64", "long", "longlong"},
     {"uint64", "ulong", "ulonglong"},
     {"float16", "half", "half"},
     {"float", "float32", "float32"},
     {"double", "float64", "float64"}}};

struct Property
{
    std::string name;
    ScalarType type = ScalarType::Int8;
    std::optional<ScalarType> count_type; ///< A list is counted by this.
    int coordinate = -1;                  ///< 0, 1, 2 for x, y, z of a vertex.
    bool is_corners = false;              ///< The list of the vertices of a face.
};

struct Element
{
    std::string name;
    std::int64_t count = 0;
    std::vector<Property> properties;

    [[nodiscard]] bool is_vertex() const { return name == "vertex"; }
    [[nodiscard]] bool is_face() const { return name == "face"; }
};

enum class Encoding
{
    Ascii,
    LittleEndian,
    BigEndian,
};

struct Header
{
    Encoding encoding = Encoding::Ascii;
    std::vector<Element> elements;
};

Encoding parse_encoding(LineReader& reader)
{
    const std::string_view name = reader.word("the encoding");
    const std::string_view version = reader.word("the version");
    if (version != "1.0")
        reader.fail(join("version is ", in_quotes(version), ", must be 1.0"));
    reader.finish_line();
    if (name == "ascii")
        return Encoding::Ascii;
    if (name == "binary_little_endian")
        return Encoding::LittleEndian;
    if (name == "binary_big_endian")
        return Encoding::BigEndian;
    reader.fail(join("encoding is ", in_quotes(name),
                     ", must be ascii, binary_little_endian or binary_big_endian"));
}

ScalarType parse_scalar(const LineReader& reader, std::string_view name)
{
    for (std::size_t i = 0; i < scalar_names.size(); ++i)
        if (std::find(scalar_names[i].begin(), scalar_names[i].end(), name) !=
            scalar_names[i].end())
            return static_cast<ScalarType>(i);
    reader.fail(join("unknown type ", in_quotes(name), "; export the property as float or int"));
}

/// @param before  Names of the elements before, and after it of this one too.
Element parse_element(LineReader& reader, std::set<std::string>& before)
{
    Element element;
    element.name = reader.word("the name of the element");
    element.count = reader.integer("the count of the element");
    reader.finish_line();
    if (element.count < 0)
        reader.fail(join("the count of the element is ", element.count, ", must be at least 0"));
    if (!before.insert(element.name).second)
        reader.fail(join("element ", in_quotes(element.name), " is declared twice"));
    return element;
}

/// @param before  Names of the properties of the element before, and after it of this one too.
Property parse_property(LineReader& reader, const Element& element, std::set<std::string>& before)
{
    Property property;
    std::string_view type = reader.word("the type of the property");
    if (type == "list") {
        property.count_type = parse_scalar(reader, reader.word("the type of the list's count"));
        if (!is_integer(*property.count_type))
            reader.fail("the count of a list must have an integer type");
        type = reader.word("the type of the list's items");
    }
    property.type = parse_scalar(reader, type);
    property.name = reader.word("the name of the property");
    reader.finish_line();
    if (!before.insert(property.name).second)
        reader.fail(join("property ", in_quotes(property.name), " is declared twice"));
    const std::size_t axis = std::string_view("xyz").find(property.name);
    if (element.is_vertex() && property.name.size() == 1 && axis != std::string_view::npos)
        property.coordinate = static_cast<int>(axis);
    property.is_corners =
        element.is_face() && (property.name == "vertex_indices" || property.name == "vertex_index");
    if (property.coordinate >= 0 && property.count_type)
        reader.fail(join("property ", in_quotes(property.name), " must not be a list"));
    if (property.is_corners && (!property.count_type || !is_integer(property.type)))
        reader.fail(join("property ", in_quotes(property.name), " must be a list of integers"));
    return property;
}

/// What a mesh needs must be declared, once.
void check_header(const LineReader& reader, const Header& header)
{
    int coordinates = 0;
    int corner_lists = 0;
    for (const Element& element : header.elements) {
        if (element.name == "tristrips" && element.count > 0)
            reader.fail("the faces are triangle strips; export them as single triangles");
        if (element.properties.empty() && element.count > 0)
            reader.fail(join("element ", in_quotes(element.name), " has no properties"));
        for (const Property& property : element.properties) {
            coordinates += property.coordinate >= 0 ? 1 : 0;
            corner_lists += property.is_corners ? 1 : 0;
        }
    }
    if (coordinates != 3)
        reader.fail("the header declares no element 'vertex' with x, y and z");
    const auto is_of_faces = [](const Element& element) { return element.is_face(); };
    if (std::ranges::none_of(header.elements, is_of_faces))
        reader.fail(
            "the file is a point cloud, its header declares no element 'face'; export the "
            "mesh with its faces");
    if (corner_lists != 1)
        reader.fail("the header must declare an element 'face' with one list 'vertex_indices'");
}

Header parse_header(LineReader& reader)
{
    if (!reader.next_line() || reader.token() != "ply" || !reader.line_done())
        reader.fail("must be 'ply'; is this a PLY file?");
    Header header;
    std::optional<Encoding> encoding;
    std::set<std::string> elements;
    std::set<std::string> properties; // of the last element
    while (reader.next_line()) {
        const std::string_view keyword = reader.token();
        if (keyword == "comment" || keyword == "obj_info")
            continue;
        if (keyword == "format" && !encoding) {
            encoding = parse_encoding(reader);
            continue;
        }
        if (!encoding)
            reader.fail("must be 'format <encoding> 1.0'");
        if (keyword == "end_header") {
            reader.finish_line();
            header.encoding = *encoding;
            check_header(reader, header);
            return header;
        }
        if (keyword == "element") {
            header.elements.push_back(parse_element(reader, elements));
            properties.clear();
        } else if (keyword == "property" && header.elements.empty()) {
            reader.fail("a property stands before the first element");
        } else if (keyword == "property") {
            header.elements.back().properties.push_back(
                parse_property(reader, header.elements.back(), properties));
        } else {
            reader.fail(join("unknown header line ", in_quotes(keyword)));
        }
    }
    reader.fail(encoding ? "the header has no end_header" : "must be 'format <encoding> 1.0'");
}

/// Values of an ascii body: one line an element.
class AsciiBody
{
public:
    explicit AsciiBody(LineReader& reader, std::size_t size)
        : reader_(reader), remaining_(static_cast<std::int64_t>(size - reader.offset()) + 1)
    {
    }

    [[nodiscard]] std::int64_t remaining() const { return remaining_; }
    static std::int64_t least_size(ScalarType) { return 2; } ///< A digit and what ends it.

    void begin(const Element& element, std::int64_t index)
    {
        if (!reader_.next_line())
            fail(join("the file ends before ", element.name, " ", index, " of ", element.count));
    }
    double number(ScalarType) { return reader_.number("coordinate"); }
    /// @param name  Gives what the value is, for messages.
    /// @param gaps  Whether there may be none: NaN.
    template <class Name>
    double scalar(ScalarType, const Name& name, bool gaps)
    {
        const std::string_view text = reader_.word("a property");
        const std::optional<double> value = spelled_number(text);
        if (value)
            return *value;
        if (!gaps || !(spells_a_number(text) || label_value(text).empty()))
            fail(join(name(), " is ", in_quotes(text), ", must be a finite number"));
        return std::numeric_limits<double>::quiet_NaN();
    }
    std::int64_t integer(ScalarType) { return reader_.integer("entry of a list"); }
    void skip(ScalarType, std::int64_t count)
    {
        for (; count > 0; --count)
            (void)reader_.word("a property");
    }
    void end() { reader_.finish_line(); }
    void finish()
    {
        if (reader_.next_line())
            fail("there are more lines than the header declares");
    }
    [[noreturn]] void fail(std::string_view rule) const { reader_.fail(rule); }

private:
    LineReader& reader_;
    std::int64_t remaining_; ///< One more than there is: the last line may lack its end.
};

/// Values of a binary body in either order of bytes.
class BinaryBody
{
public:
    BinaryBody(std::string_view content, std::size_t offset, std::string path, bool swap)
        : content_(content), offset_(offset), path_(std::move(path)), swap_(swap)
    {
    }

    [[nodiscard]] std::int64_t remaining() const
    {
        return static_cast<std::int64_t>(content_.size() - offset_);
    }
    static std::int64_t least_size(ScalarType type) { return size_of(type); }

    void begin(const Element& element, std::int64_t index) const
    {
        if (remaining() == 0)
            fail(join("the file ends before ", element.name, " ", index, " of ", element.count));
    }
    double number(ScalarType type)
    {
        const char* bytes = next(type);
        offset_ += to_size(size_of(type));
        return number_at(bytes, type, swap_);
    }
    template <class Name>
    double scalar(ScalarType type, const Name& name, bool gaps)
    {
        const double value = number(type);
        if (std::isfinite(value))
            return value;
        if (!gaps)
            fail(join(name(), " is not finite"));
        return std::numeric_limits<double>::quiet_NaN();
    }
    std::int64_t integer(ScalarType type)
    {
        const std::optional<std::int64_t> value = integer_at(next(type), type, swap_);
        if (!value)
            fail(join("an integer is ", unsigned_at(next(type), swap_),
                      ", which is beyond what can be counted, 2^63 - 1"));
        offset_ += to_size(size_of(type));
        return *value;
    }
    void skip(ScalarType type, std::int64_t count)
    {
        if (count > remaining() / size_of(type))
            fail("the file ends within an element");
        offset_ += to_size(count * size_of(type));
    }
    void end() {}
    void finish() const
    {
        const std::string_view rest = content_.substr(offset_);
        if (rest != "\n" && rest != "\r\n" && !rest.empty()) // some writers end the last line
            fail(join(counted(remaining(), "byte"), " more than the header declares"));
    }
    [[noreturn]] void fail(std::string_view rule) const
    {
        throw InvalidInput(join(path_, ": byte ", offset_, ": ", rule));
    }

private:
    [[nodiscard]] const char* next(ScalarType type) const
    {
        if (remaining() < size_of(type))
            fail("the file ends within an element");
        return content_.data() + offset_;
    }

    std::string_view content_;
    std::size_t offset_;
    std::string path_;
    bool swap_;
};

/// Counts are believed only if the rest of the file can hold that many elements.
template <class Body>
void check_counts(const Header& header, const Body& body)
{
    std::int64_t remaining = body.remaining();
    for (const Element& element : header.elements) {
        std::int64_t least = 0;
        for (const Property& property : element.properties)
            least += Body::least_size(property.count_type.value_or(property.type));
        if (element.count > 0 && element.count > remaining / least)
            body.fail(join(element.count, " of element ", in_quotes(element.name),
                           " do not fit in the remaining ", counted(remaining, "byte")));
        remaining -= element.count * least;
    }
}

/// A property of the vertices or faces to be read beside the mesh.
struct WantedScalar
{
    std::string_view element;
    std::string_view name;
    bool gaps = false;            ///< Values that are not finite are NaN, else refused.
    std::vector<double> values{}; ///< One a vertex or triangle: those of a polygon share its value.
    std::vector<std::string> names{}; ///< What could be wanted of this file.

    [[nodiscard]] bool is(const Element& in, const Property& property) const
    {
        return in.name == element && property.name == name && !property.count_type;
    }
};

/// @param scalar  None if null.
template <class Body>
void parse_body(const Header& header, Body& body, MeshBuilder& mesh, WantedScalar* scalar)
{
    check_counts(header, body);
    for (const Element& element : header.elements) {
        mesh.reserve(element.is_vertex() ? element.count : 0,
                     element.is_face() ? element.count : 0);
        if (element.is_vertex())
            mesh.expect_vertices(element.count);
    }
    std::array<double, 3> point{};
    std::vector<std::int64_t> corners;
    for (const Element& element : header.elements)
        for (std::int64_t i = 0; i < element.count; ++i) {
            body.begin(element, i);
            std::optional<double> value;
            for (const Property& property : element.properties) {
                const std::int64_t count =
                    property.count_type ? body.integer(*property.count_type) : 1;
                if (count < 0)
                    body.fail(join("a list has ", count, " entries"));
                const bool is_wanted = scalar != nullptr && scalar->is(element, property);
                if (property.coordinate >= 0) {
                    double& coordinate = point[to_size(property.coordinate)];
                    coordinate = body.number(property.type);
                    if (is_wanted)
                        value = coordinate;
                } else if (is_wanted) {
                    const auto name = [&] {
                        return join("property ", in_quotes(property.name), " of ", element.name,
                                    " ", i);
                    };
                    value = body.scalar(property.type, name, scalar->gaps);
                } else if (property.is_corners) {
                    if (count > MeshBuilder::corner_limit)
                        body.fail(join("a face has ", count, " corners; the limit is ",
                                       MeshBuilder::corner_limit));
                    corners.resize(to_size(count));
                    for (std::int64_t& corner : corners)
                        corner = body.integer(property.type);
                } else {
                    body.skip(property.type, count);
                }
            }
            if (element.is_vertex())
                mesh.add_vertex(point[0], point[1], point[2]);
            else if (element.is_face())
                mesh.add_polygon(corners);
            if (value)
                scalar->values.resize(
                    to_size(element.is_vertex() ? mesh.vertex_count() : mesh.face_count()), *value);
            body.end();
        }
    body.finish();
}

NamedMesh parse(std::string_view content, const std::filesystem::path& path,
                const MeshReadOptions& options, WantedScalar* scalar)
{
    LineReader reader(content, path.string());
    const Header header = parse_header(reader);
    if (scalar != nullptr)
        for (const Element& element : header.elements)
            for (const Property& property : element.properties)
                if (element.name == scalar->element && !property.count_type)
                    scalar->names.push_back(property.name);
    const auto read = [&](auto body) {
        MeshBuilder mesh(path, options, [&](std::string_view rule) { body.fail(rule); });
        parse_body(header, body, mesh, scalar);
        return mesh.finish();
    };
    if (header.encoding == Encoding::Ascii)
        return read(AsciiBody(reader, content.size()));
    const bool is_native =
        (header.encoding == Encoding::LittleEndian) == (std::endian::native == std::endian::little);
    return read(BinaryBody(content, reader.offset(), path.string(), !is_native));
}

/// Values of an element behind one another, as text or as bytes.
class PlyWriter
{
public:
    PlyWriter(std::string& text, bool ascii) : text_(text), ascii_(ascii) {}

    template <class Value>
    void value(Value value)
    {
        if (!ascii_) {
            text_.append(reinterpret_cast<const char*>(&value), sizeof value);
            return;
        }
        if (!text_.ends_with('\n'))
            text_ += ' ';
        if constexpr (sizeof(Value) == 1)
            append_number(text_, int{value});
        else
            append_number(text_, value);
    }
    void end()
    {
        if (ascii_)
            text_ += '\n';
    }

private:
    std::string& text_;
    bool ascii_;
};

template <class Real>
std::string print(const Points& points, const Faces& faces, const MeshWriteOptions& options)
{
    static_assert(std::endian::native == std::endian::little, "values are written as they are");
    const std::string type = std::is_same_v<Real, float> ? "float" : "double";
    std::string text = join("ply\nformat ", options.ascii ? "ascii" : "binary_little_endian",
                            " 1.0\nelement vertex ", points.rows(), "\nproperty ", type,
                            " x\nproperty ", type, " y\nproperty ", type, " z\n");
    const VertexScalar* quality = nullptr;
    for (const VertexScalar& scalar : options.scalars) {
        text += "property " + type + " " + scalar.name + "\n";
        if (scalar.name == options.quality)
            quality = &scalar;
    }
    if (quality != nullptr)
        text += "property " + type + " quality\n";
    if (options.colours.rows() > 0)
        text += "property uchar red\nproperty uchar green\nproperty uchar blue\n";
    text += join("element face ", faces.rows(),
                 "\nproperty list uchar int vertex_indices\nend_header\n");
    const auto vertex_size =
        static_cast<Eigen::Index>(sizeof(Real) * (4 + options.scalars.size()) + 3);
    text.reserve(text.size() + to_size(points.rows() * vertex_size + faces.rows() * 13));
    PlyWriter out(text, options.ascii);
    for (Eigen::Index v = 0; v < points.rows(); ++v) {
        for (int axis = 0; axis < 3; ++axis)
            out.value(static_cast<Real>(points(v, axis)));
        for (const VertexScalar& scalar : options.scalars)
            out.value(static_cast<Real>(scalar.values[v]));
        if (quality != nullptr)
            out.value(static_cast<Real>(quality->values[v]));
        if (options.colours.rows() > 0)
            for (int channel = 0; channel < 3; ++channel)
                out.value(options.colours(v, channel));
        out.end();
    }
    for (Eigen::Index f = 0; f < faces.rows(); ++f) {
        out.value(std::uint8_t{3});
        for (int corner = 0; corner < 3; ++corner)
            out.value(faces(f, corner));
        out.end();
    }
    return text;
}

Eigen::VectorXd read_scalar(const std::filesystem::path& path, WantedScalar scalar)
{
    if (mesh_format(path) != MeshFormat::Ply)
        throw InvalidInput(join(path.string(), ": values of its ", scalar.element,
                                " elements are read from PLY files alone; write it as .ply"));
    (void)parse(read_file(path, MeshBuilder::file_limit), path, {.triangulate = true}, &scalar);
    if (scalar.values.empty()) {
        std::vector<std::size_t> all(scalar.names.size());
        std::iota(all.begin(), all.end(), 0);
        throw InvalidInput(join(
            path.string(), ": its ", scalar.element, " elements have no property ",
            in_quotes(scalar.name),
            all.empty() ? " and no other one" : "; they have " + list_names(scalar.names, all)));
    }
    return Eigen::Map<const Eigen::VectorXd>(scalar.values.data(),
                                             static_cast<Eigen::Index>(scalar.values.size()));
}

bool is_property_name(std::string_view name)
{
    const auto is_letter = [](char c) {
        return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_';
    };
    const auto is_usual = [&](char c) { return is_letter(c) || (c >= '0' && c <= '9'); };
    return !name.empty() && is_letter(name.front()) && name != "x" && name != "y" && name != "z" &&
           std::all_of(name.begin(), name.end(), is_usual);
}

} // namespace

void internal::check_scalars(const MeshWriteOptions& options, Eigen::Index vertices)
{
    std::set<std::string> names;
    for (const VertexScalar& scalar : options.scalars) {
        const std::string place = join("scalar ", in_quotes(scalar.name));
        if (!is_property_name(scalar.name) || !names.insert(scalar.name).second)
            throw InvalidInput(join(place, ": the name must be of letters, digits and _, start ",
                                    "with no digit, and be used once; x, y and z are taken"));
        if (scalar.values.size() != vertices)
            throw InvalidInput(join(place, " has ", counted(scalar.values.size(), "value"),
                                    ", the mesh has ", vertices, " vertices"));
        for (Eigen::Index v = 0; v < vertices; ++v)
            if (!std::isfinite(scalar.values[v]))
                throw InvalidInput(
                    join(place, ": value ", v, " is ", scalar.values[v], ", must be finite"));
        if (options.single_precision && !scalar.values.cast<float>().allFinite())
            throw InvalidInput(join(place, ": a value is beyond single precision"));
    }
    if (!options.quality.empty() && (!names.contains(options.quality) || names.contains("quality")))
        throw InvalidInput(join("quality is ", in_quotes(options.quality),
                                ", must be one of the scalars, none of which is called quality"));
}

void internal::check_colour_names(const MeshWriteOptions& options,
                                  std::initializer_list<std::string_view> taken)
{
    if (options.colours.rows() == 0)
        return;
    for (const VertexScalar& scalar : options.scalars)
        if (std::find(taken.begin(), taken.end(), scalar.name) != taken.end())
            throw InvalidInput(join("scalar ", in_quotes(scalar.name),
                                    ": colours are written under this name; call it otherwise"));
}

NamedMesh internal::parse_ply(std::string_view content, const std::filesystem::path& path,
                              const MeshReadOptions& options)
{
    return parse(content, path, options, nullptr);
}

std::string internal::print_ply(const Points& points, const Faces& faces,
                                const MeshWriteOptions& options)
{
    check_colour_names(options, {"red", "green", "blue"});
    return options.single_precision ? print<float>(points, faces, options)
                                    : print<double>(points, faces, options);
}

void write_vertex_scalars(const std::filesystem::path& path, const Points& points,
                          const Faces& faces, const std::vector<VertexScalar>& scalars)
{
    MeshWriteOptions options{.scalars = scalars};
    if (!scalars.empty() &&
        std::ranges::none_of(scalars, [](const VertexScalar& s) { return s.name == "quality"; }))
        options.quality = scalars.front().name;
    write_mesh(path, points, faces, mesh_format(path), options);
}

Eigen::VectorXd read_vertex_scalar(const std::filesystem::path& path, std::string_view name)
{
    return read_scalar(path, {.element = "vertex", .name = name});
}

Eigen::VectorXd read_vertex_scalar_with_gaps(const std::filesystem::path& path,
                                             std::string_view name)
{
    return read_scalar(path, {.element = "vertex", .name = name, .gaps = true});
}

Eigen::VectorXd read_face_scalar(const std::filesystem::path& path, std::string_view name)
{
    return read_scalar(path, {.element = "face", .name = name});
}

} // namespace shape
