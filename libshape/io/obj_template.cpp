// SPDX-License-Identifier: MIT

#include "libshape/io/obj_template.h"

#include <Eigen/Geometry>
#include <array>
#include <functional>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/to_size.h"
#include "libshape/io/file/input_file.h"
#include "libshape/io/file/line_reader.h"
#include "libshape/io/mesh_builder.h"
#include "libshape/io/mesh_formats.h"

namespace shape {
using namespace internal;
namespace {

constexpr std::string_view blanks = " \t\r";

/// Takes the first word off a line.
std::string_view take_word(std::string_view& line)
{
    line.remove_prefix(std::min(line.find_first_not_of(blanks), line.size()));
    const std::string_view word = line.substr(0, line.find_first_of(blanks));
    line.remove_prefix(word.size());
    return word;
}

void for_each_line(std::string_view text, const std::function<void(std::string_view)>& take)
{
    while (!text.empty()) {
        const std::size_t end = std::min(text.find('\n'), text.size());
        std::string_view line = text.substr(0, end);
        if (line.ends_with('\r'))
            line.remove_suffix(1);
        take(line);
        text.remove_prefix(std::min(end + 1, text.size()));
    }
}

/// The index from 0 that an OBJ reference means, -1 for none.
std::int64_t reference(std::string_view text, std::int64_t count)
{
    const std::int64_t index = spelled_integer(text).value_or(0);
    const std::int64_t from_zero = index > 0 ? index - 1 : count + index;
    return index != 0 && from_zero >= 0 ? from_zero : -1;
}

/// Normals of the template's statements `vn`: sums, by area, over the faces that name them.
Points template_normals(std::string_view text, const Points& points)
{
    std::int64_t vertices = 0;
    std::int64_t normals = 0;
    for_each_line(text, [&](std::string_view line) { normals += take_word(line) == "vn" ? 1 : 0; });
    Points sums = Points::Zero(normals, 3);
    normals = 0;
    for_each_line(text, [&](std::string_view line) {
        const std::string_view keyword = take_word(line);
        vertices += keyword == "v" ? 1 : 0;
        normals += keyword == "vn" ? 1 : 0;
        if (keyword != "f")
            return;
        std::vector<std::int64_t> corners;
        std::vector<std::int64_t> named;
        for (std::string_view corner = take_word(line); !corner.empty() && corner.front() != '#';
             corner = take_word(line)) {
            const std::size_t slash = corner.find('/');
            const std::size_t second = slash == corner.npos ? slash : corner.find('/', slash + 1);
            corners.push_back(reference(corner.substr(0, slash), vertices));
            named.push_back(second == corner.npos ? -1
                                                  : reference(corner.substr(second + 1), normals));
        }
        Eigen::RowVector3d area = Eigen::RowVector3d::Zero();
        for (std::size_t c = 2; c < corners.size(); ++c)
            area += (points.row(corners[c - 1]) - points.row(corners[0]))
                        .cross(points.row(corners[c]) - points.row(corners[0]));
        for (const std::int64_t n : named)
            if (n >= 0 && n < sums.rows())
                sums.row(n) += area;
    });
    for (auto row : sums.rowwise())
        if (row.norm() > 0.0)
            row = Eigen::RowVector3d(row).stableNormalized();
    return sums;
}

/// The name of a material library as it is seen from another folder; as it is where there is none.
std::string library_from(std::string_view name, const std::filesystem::path& folder,
                         const std::filesystem::path& output_folder)
{
    name.remove_prefix(std::min(name.find_first_not_of(blanks), name.size()));
    std::error_code ignored;
    const std::filesystem::path file = folder / std::string(name);
    if (name.empty() || !std::filesystem::is_regular_file(file, ignored))
        return std::string(name);
    return std::filesystem::proximate(file, output_folder).generic_string();
}

} // namespace

ObjTemplate read_obj_template(const std::filesystem::path& path,
                              const std::filesystem::path& output_folder)
{
    if (mesh_format(path) != MeshFormat::Obj)
        throw InvalidInput(join(path.string(), ": a template must be an OBJ file (.obj)"));
    const std::string content = read_file(path, MeshBuilder::file_limit);
    ObjTemplate result{{}, parse_obj(content, path, {.triangulate = true}).faces};
    const std::filesystem::path folder = path.has_parent_path() ? path.parent_path() : ".";
    const std::filesystem::path target = output_folder.empty() ? "." : output_folder;
    result.text.reserve(content.size());
    for_each_line(content, [&](std::string_view line) {
        std::string_view rest = line;
        const std::string_view keyword = take_word(rest);
        if (keyword == "mtllib") {
            result.text += join("mtllib ", library_from(rest, folder, target), "\n");
            return;
        }
        if (line.ends_with('\\'))
            throw InvalidInput(join(path.string(), ": the statement ", in_quotes(line),
                                    " goes on in the next line, which a template may not; join "
                                    "the two"));
        result.text.append(line);
        result.text += '\n';
    });
    return result;
}

std::string internal::print_obj_template(const ObjTemplate& model, const Points& points)
{
    Eigen::Index vertices = 0;
    for_each_line(model.text,
                  [&](std::string_view line) { vertices += take_word(line) == "v" ? 1 : 0; });
    if (vertices != points.rows()) // some belong to no face: the faces are the same
        throw InvalidInput(join("the template has ", vertices, " vertices, the mesh ",
                                points.rows(), "; take away those that belong to no face"));
    const Points normals = template_normals(model.text, points);
    std::string text;
    text.reserve(model.text.size() + to_size(points.rows()) * 32);
    Eigen::Index vertex = 0;
    Eigen::Index normal = 0;
    for_each_line(model.text, [&](std::string_view line) {
        std::string_view rest = line;
        const std::string_view keyword = take_word(rest);
        if (keyword == "vn") {
            const Eigen::RowVector3d row = normals.row(normal++);
            if (row.norm() > 0.0)
                append_line(text, "vn", row);
            else // no face names it
                text += std::string(line) + '\n';
            return;
        }
        if (keyword != "v") {
            text += std::string(line) + '\n';
            return;
        }
        append_line(text, "v", points.row(vertex++));
        for (int axis = 0; axis < 3; ++axis)
            (void)take_word(rest);
        if (!rest.empty()) { // colours
            text.pop_back();
            text += std::string(rest) + '\n';
        }
    });
    return text;
}

} // namespace shape
