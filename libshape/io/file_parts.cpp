// SPDX-License-Identifier: MIT

#include "libshape/io/file_parts.h"

#include <array>
#include <set>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/version.h"

namespace shape::internal {
namespace {

constexpr std::int64_t format_version = 1;

constexpr std::array<const char*, 3> format_names = {"libshape collection", "libshape model",
                                                     "libshape difference"};

const char* format_name(FileKind kind)
{
    return format_names[static_cast<std::size_t>(kind)];
}

FileKind read_kind(const Hdf5File& file)
{
    const std::string format = file.text_attribute("format");
    for (std::size_t i = 0; i < format_names.size(); ++i)
        if (format == format_names[i])
            return static_cast<FileKind>(i);
    file.fail("attribute format", join("is '", format, "', must be '", format_names[0], "', '",
                                       format_names[1], "' or '", format_names[2], "'"));
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
    const FileKind found = read_kind(file);
    if (found != kind)
        file.fail("attribute format",
                  join("is '", format_name(found), "', must be '", format_name(kind), "'"));
    const std::int64_t version = file.integer_attribute("format_version");
    if (version != format_version)
        file.fail("attribute format_version",
                  join("is ", version, "; this program reads ", format_version));
}

void add_topology(Hdf5Content& content, const Topology& topology)
{
    const auto add = [&](const char* name, const auto& matrix) {
        content.datasets.push_back(
            {name,
             {matrix.rows(), matrix.cols()},
             std::span<const int>(matrix.data(), static_cast<std::size_t>(matrix.size()))});
    };
    add("/topology/faces", topology.faces());
    add("/topology/edges", topology.edges());
}

Topology read_topology(const Hdf5File& file, Eigen::Index vertex_count)
{
    const Faces faces = file.integers("/topology/faces", {any_length, 3});
    const Topology topology = [&] {
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
    return topology;
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
        if (!seen.insert(name).second)
            throw InvalidInput(join("the name '", name, "' occurs twice; names must differ"));
}

std::vector<std::string> read_names(const Hdf5File& file, Eigen::Index count)
{
    std::vector<std::string> names = file.strings("/names", count);
    std::set<std::string_view> seen;
    for (const std::string& name : names)
        if (!seen.insert(name).second)
            file.fail("/names", join("'", name, "' occurs twice"));
    return names;
}

void add_labels(Hdf5Content& content, Eigen::Index count, const Labels& labels)
{
    std::set<std::string_view> seen;
    for (const LabelColumn& column : labels) {
        if (column.name.empty() || column.name == "." ||
            column.name.find_first_of(std::string_view("/\0", 2)) != std::string::npos)
            throw InvalidInput(join("label column '", column.name,
                                    "': a name in a file must not be empty, '.' or hold '/'"));
        if (!seen.insert(column.name).second)
            throw InvalidInput(join("label column '", column.name, "' occurs twice"));
        add_strings(content, "/labels/" + column.name, count, column.values);
    }
}

Labels read_labels(const Hdf5File& file, Eigen::Index count)
{
    Labels labels;
    for (const std::string& name : file.members("/labels"))
        labels.push_back({name, file.strings("/labels/" + name, count)});
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
    return internal::read_kind(internal::Hdf5File(path));
}
