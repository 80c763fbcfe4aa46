// SPDX-License-Identifier: MIT

#include "libshape/io/file_parts.h"

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cstdint>
#include <map>
#include <optional>
#include <set>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/to_size.h"
#include "libshape/base/version.h"
#include "libshape/io/file/line_reader.h"
#include "libshape/io/hdf5/handles.h"
#include "libshape/io/label_file.h"

namespace shape::internal {
namespace {

constexpr std::int64_t format_version = 1;

constexpr std::array<const char*, 3> format_names = {"libshape collection", "libshape model",
                                                     "libshape difference"};

const char* format_name(FileKind kind)
{
    return format_names[to_size(static_cast<int>(kind))];
}

[[noreturn]] void refuse_kind(const Hdf5File& file, std::optional<FileKind> wanted,
                              const std::string& rule)
{
    throw WrongFileKind(join(file.path(), ": attribute format: ", rule), wanted);
}

/// @param wanted  For the exception alone.
FileKind read_kind(const Hdf5File& file, std::optional<FileKind> wanted)
{
    if (!file.has_attribute("format"))
        refuse_kind(file, wanted,
                    file.has("/representer") && file.has("/model")
                        ? "is missing: the file is a model for Statismo, which cannot be read "
                          "back; give the model of libshape that it was made from"
                        : "is missing: the file is not one of libshape");
    const std::string format = file.text_attribute("format");
    for (std::size_t i = 0; i < format_names.size(); ++i)
        if (format == format_names[i])
            return static_cast<FileKind>(i);
    refuse_kind(file, wanted,
                join("is '", format, "', must be '", format_names[0], "', '", format_names[1],
                     "' or '", format_names[2], "'"));
}

} // namespace

Hdf5Content begin_content(FileKind kind)
{
    return {{{"format", std::string(format_name(kind))},
             {"format_version", format_version},
             {"program_version", join("libshape ", version())}},
            {}};
}

void check_kind(const Hdf5File& file, FileKind kind)
{
    const FileKind found = read_kind(file, kind);
    if (found != kind)
        refuse_kind(file, kind,
                    join("is '", format_name(found), "', must be '", format_name(kind), "'"));
    const std::int64_t version = file.integer_attribute("format_version");
    if (version != format_version)
        file.fail("attribute format_version",
                  join("is ", version, "; this program reads ", format_version));
}

namespace {

/// FNV-1a over the entries, row by row: tells whether faces were changed, in any way, after a file was
/// written.
std::int64_t checksum(const Faces& faces)
{
    std::uint64_t hash = 0xcbf29ce484222325;
    for (Eigen::Index f = 0; f < faces.rows(); ++f)
        for (int c = 0; c < 3; ++c)
            for (int byte = 0; byte < 4; ++byte) {
                hash ^= (static_cast<std::uint32_t>(faces(f, c)) >> (8 * byte)) & 0xff;
                hash *= 0x100000001b3;
            }
    return std::bit_cast<std::int64_t>(hash);
}

} // namespace

void add_topology(Hdf5Content& content, const Topology& topology)
{
    const auto add = [&](const char* name, const auto& matrix) {
        content.datasets.push_back({name,
                                    {matrix.rows(), matrix.cols()},
                                    std::span<const int>(matrix.data(), to_size(matrix.size()))});
    };
    add("/topology/faces", topology.faces());
    add("/topology/edges", topology.edges());
    content.attributes.emplace_back("faces_checksum", checksum(topology.faces()));
}

Topology read_topology(const Hdf5File& file, Eigen::Index vertex_count)
{
    const Faces faces = file.integers("/topology/faces", {any_length, 3});
    Topology topology = [&] {
        try {
            return Topology(faces, static_cast<int>(vertex_count));
        } catch (const InvalidInput& error) {
            file.fail("/topology/faces", error.what());
        }
    }();
    const Edges edges = file.integers("/topology/edges", {topology.edge_count(), 2});
    for (Eigen::Index e = 0; e < edges.rows(); ++e)
        if (edges.row(e) != topology.edges().row(e))
            file.fail("/topology/edges", join("row ", e, " is (", edges(e, 0), ", ", edges(e, 1),
                                              "), the faces give (", topology.edges()(e, 0), ", ",
                                              topology.edges()(e, 1), ")"));
    if (file.has_attribute("faces_checksum") &&
        file.integer_attribute("faces_checksum") != checksum(faces))
        file.fail("/topology/faces",
                  "are not those that the file was written with (attribute faces_checksum)");
    return topology;
}

void check_boundary_angles(const Hdf5File& file, const std::string& name, const Topology& topology,
                           const RowMatrix& angles)
{
    // They are written as 0, and other programs may measure them to rounding.
    for (Eigen::Index e = 0; e < topology.edge_count(); ++e)
        if (topology.is_boundary_edge(static_cast<int>(e)) &&
            !(angles.col(e).cwiseAbs().maxCoeff() <= 1e-9))
            file.fail(name, join("edge ", e,
                                 " is on the boundary of /topology/faces and has an angle "
                                 "that is not 0: faces are missing"));
}

void add_strings(Hdf5Content& content, std::string name, Eigen::Index count,
                 const std::vector<std::string>& strings)
{
    content.datasets.push_back({std::move(name), {count}, std::span<const std::string>(strings)});
}

void add_names(Hdf5Content& content, Eigen::Index count, const std::vector<std::string>& names)
{
    add_strings(content, "/names", count, names);
    std::set<std::string_view> seen;
    for (const std::string& name : names)
        if (name.empty())
            throw InvalidInput("a mesh has no name");
        else if (!seen.insert(name).second)
            throw InvalidInput(join("the name '", name, "' occurs twice; names must differ"));
}

std::vector<std::string> read_names(const Hdf5File& file, Eigen::Index count)
{
    std::vector<std::string> names = file.strings("/names", count);
    std::set<std::string_view> seen;
    for (const std::string& name : names)
        if (name.empty())
            file.fail("/names", "a mesh has no name");
        else if (!seen.insert(name).second)
            file.fail("/names", join("'", name, "' occurs twice"));
    return names;
}

namespace {

constexpr const char* names_attribute = "label_names";
constexpr const char* percent_encoded = "percent-encoded";

/// Whether HDF5 takes the name for something else: a path, or the group itself.
bool needs_escapes(const std::string& name)
{
    return name == "." || name.find('/') != std::string::npos;
}

/// Three characters for each that needs it, as in addresses of the web (RFC 3986, section 2.1).
std::string escaped(const std::string& name)
{
    if (name == ".")
        return "%2E";
    std::string result;
    for (const char c : name)
        result += c == '/' ? "%2F" : c == '%' ? "%25" : std::string(1, c);
    return result;
}

/// Any character of ASCII may be written so, for other programs may escape more than is needed.
std::string unescaped(const Hdf5File& file, const std::string& member)
{
    const auto fail = [&] {
        file.fail("/labels/" + member,
                  join("its name is not percent-encoded, as attribute ", names_attribute, " says"));
    };
    std::string result;
    for (std::size_t i = 0; i < member.size(); ++i) {
        if (member[i] != '%') {
            result += member[i];
            continue;
        }
        int code = 0;
        const char* const digits = member.data() + i + 1;
        if (i + 2 >= member.size() ||
            std::from_chars(digits, digits + 2, code, 16).ptr != digits + 2 || code < 1 ||
            code > 0x7f)
            fail();
        result += static_cast<char>(code);
        i += 2;
    }
    return result;
}

} // namespace

void add_labels(Hdf5Content& content, Eigen::Index count, const Labels& labels)
{
    // A dataset each, which HDF5 opens and checks in some 0.3 ms: files that are opened in more than seconds are taken
    // for hostile (hdf5/isolation.cpp).
    constexpr std::size_t most_columns = 4096;
    if (labels.size() > most_columns)
        throw LimitExceeded(join("there are ", labels.size(), " label columns; a file takes ",
                                 most_columns, ": leave out those that are not needed"));
    const bool are_escaped = std::ranges::any_of(
        labels, [](const LabelColumn& column) { return needs_escapes(column.name); });
    if (are_escaped)
        content.attributes.emplace_back(names_attribute, std::string(percent_encoded));
    std::set<std::string> seen; // as tables spell them
    for (const LabelColumn& column : labels) {
        if (!is_storable_label(column.name))
            throw InvalidInput(
                join("label column ", in_quotes(column.name),
                     ": a name in a file must not be empty or hold NUL; rename the column"));
        if (!seen.insert(label_name(column.name)).second)
            throw InvalidInput(join("label column ", in_quotes(column.name),
                                    " occurs twice, perhaps but for blanks or the composition of "
                                    "accents"));
        const std::string member = are_escaped ? escaped(column.name) : column.name;
        if (member.size() > longest_string)
            throw InvalidInput(join("label column ", in_quotes(column.name), ": the name has ",
                                    member.size(), " bytes, a file takes ", longest_string,
                                    "; rename the column"));
        add_strings(content, "/labels/" + member, count, column.values);
    }
}

Labels read_labels(const Hdf5File& file, Eigen::Index count)
{
    const bool are_escaped = file.has_attribute(names_attribute);
    if (are_escaped && file.text_attribute(names_attribute) != percent_encoded)
        file.fail(join("attribute ", names_attribute),
                  join("is '", file.text_attribute(names_attribute), "', must be '",
                       percent_encoded, "'"));
    Labels labels;
    std::map<std::string, std::string> seen; // as tables spell them
    for (const std::string& member : file.members("/labels")) {
        const std::string name = are_escaped ? unescaped(file, member) : member;
        const auto [known, is_new] = seen.try_emplace(label_name(name), name);
        if (!is_new && known->second == name)
            file.fail("/labels/" + member, join("a second label is called '", name, "'"));
        if (!is_new)
            file.fail(
                "/labels/" + member,
                join("a label is called ", in_quotes(known->second), " and another one ",
                     in_quotes(name), ", one name but for blanks or the composition of accents"));
        labels.push_back({name, file.strings("/labels/" + member, count)});
        for (std::string& value : labels.back().values)
            value = label_value(value); // whoever wrote the file
    }
    return labels;
}

void add_scale(Hdf5Content& content, Scale scale)
{
    content.attributes.emplace_back("scale", std::string(scale == Scale::Unit ? "unit" : "none"));
}

Scale read_scale(const Hdf5File& file)
{
    const std::string scale = file.text_attribute("scale");
    if (scale != "unit" && scale != "none")
        file.fail("attribute scale", "is '" + scale + "', must be 'unit' or 'none'");
    return scale == "unit" ? Scale::Unit : Scale::None;
}

} // namespace shape::internal

shape::FileKind shape::file_kind(const std::filesystem::path& path)
{
    return internal::read_kind(internal::Hdf5File(path), std::nullopt);
}
