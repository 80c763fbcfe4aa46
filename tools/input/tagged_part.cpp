// SPDX-License-Identifier: MIT

#include "tools/input/tagged_part.h"

#include <CLI/CLI.hpp>
#include <optional>
#include <utility>

#include "libshape/base/counted.h"
#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/edge_space/tagged_scaling.h"
#include "libshape/io/index_file.h"
#include "libshape/io/vertex_scalars.h"
#include "tools/program/arguments.h"

namespace shape::tools {
using namespace internal;
namespace {

/// Where a value of a PLY file tags.
struct Label
{
    std::string name;
    std::optional<double> value; ///< None: wherever it is not 0.
};

Label read_label(const std::string& text)
{
    const std::size_t sign = text.find('=');
    if (sign == std::string::npos)
        return {text, {}};
    return {text.substr(0, sign), read_number(text.substr(sign + 1), "--scale-label")};
}

std::vector<int> indices_with(const Label& label, const Eigen::VectorXd& values, int count,
                              const std::string& path, const char* what)
{
    if (values.size() != count)
        throw InvalidInput(join(path, ": it has ", counted(values.size(), "value"), " '",
                                label.name, "', one a ", what, "; the meshes have ", count));
    std::vector<int> indices;
    for (int i = 0; i < count; ++i)
        if (label.value ? values[i] == *label.value : values[i] != 0.0)
            indices.push_back(i);
    if (indices.empty())
        throw InvalidInput(join(path, ": no ", what, " has a '", label.name, "' ",
                                label.value ? join("of ", *label.value) : "other than 0"));
    return indices;
}

std::vector<int> tagged_vertices(const TaggedPartArguments& arguments, const Topology& topology)
{
    const auto indices = [&](const std::string& path, int count, const char* what,
                             const auto& read_scalar) -> std::vector<int> {
        if (path.empty())
            return {};
        if (arguments.label.empty())
            return read_indices(path, count, what);
        const Label label = read_label(arguments.label);
        return indices_with(label, read_scalar(path, label.name), count, path, what);
    };
    std::vector<int> vertices =
        indices(arguments.vertices, topology.vertex_count(), "vertex", read_vertex_scalar);
    const std::vector<int> corners = corners_of_faces(
        topology, indices(arguments.faces, topology.face_count(), "face", read_face_scalar));
    vertices.insert(vertices.end(), corners.begin(), corners.end());
    return vertices;
}

} // namespace

void add_tagged_part_options(CLI::App& command, TaggedPartArguments& arguments)
{
    const std::string group = "A part that grows or shrinks (Winkler 2010, Fig. 12)";
    command
        .add_option(
            "--scale-vertices", arguments.vertices,
            "A file with the indices (from 0) of the vertices of a part whose edge lengths\n"
            "are multiplied along the way; or, with --scale-label, a PLY file")
        ->option_text("FILE")
        ->group(group);
    command
        .add_option("--scale-faces", arguments.faces,
                    "The same with faces, whose corners make the part")
        ->option_text("FILE")
        ->group(group);
    command
        .add_option("--scale-label", arguments.label,
                    "The part is where this property of the vertices or faces of the PLY file has\n"
                    "this value or, without one, is not 0")
        ->option_text("NAME[=VALUE]")
        ->group(group);
    command
        .add_option_function<std::string>(
            "--scale-factors",
            [&arguments](const std::string& text) {
                arguments.factors = read_numbers(text, "--scale-factors");
            },
            "Factors of that part, one a mesh, > 0, blended as the meshes are; of two meshes one\n"
            "at either end of the path")
        ->option_text("f1,f2,...")
        ->group(group);
    add_integer(
        command, "--scale-border", arguments.border,
        "Edges from the part over which the factor falls to 1, in [1, 1000] (default: 1, an\n"
        "edge with one end in the part takes the mean of the factor and 1)",
        1, 1000)
        ->group(group);
}

ShapePoint TaggedPart::scale(ShapePoint point, const Eigen::VectorXd& weights) const
{
    if (shares.size() == 0)
        return point;
    return scale_tagged(std::move(point), shares, factors.dot(weights));
}

TaggedPart read_tagged_part(const TaggedPartArguments& arguments, const Topology& topology,
                            std::size_t meshes)
{
    const bool tagged = !arguments.vertices.empty() || !arguments.faces.empty();
    const std::vector<double>& factors = arguments.factors;
    if (tagged == factors.empty())
        throw UsageError("--scale-factors and --scale-vertices or --scale-faces go together");
    if (!tagged && (!arguments.label.empty() || arguments.border != 1))
        throw UsageError("--scale-label and --scale-border need --scale-vertices or --scale-faces");
    if (!tagged)
        return {};
    if (factors.size() != meshes)
        throw InvalidInput(join("--scale-factors: ", counted(factors.size(), "factor"), " for ",
                                meshes, " meshes"));
    for (const double factor : factors)
        if (factor <= 0.0)
            throw InvalidInput(join("--scale-factors: ", factor, " is not > 0"));
    return {tagged_shares(topology, tagged_vertices(arguments, topology),
                          static_cast<int>(arguments.border)),
            Eigen::Map<const Eigen::VectorXd>(factors.data(),
                                              static_cast<Eigen::Index>(factors.size()))};
}

} // namespace shape::tools
