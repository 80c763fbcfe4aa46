// SPDX-License-Identifier: MIT

#include "libshape/io/mesh_file.h"

#include <algorithm>
#include <array>
#include <charconv>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/io/file/input_file.h"
#include "libshape/io/file/output_file.h"
#include "libshape/io/mesh_builder.h"
#include "libshape/io/mesh_formats.h"

namespace shape {
using namespace internal;
namespace {

struct Format
{
    MeshFormat format;
    const char* ending;
    /// Null if the format is only written.
    NamedMesh (*parse)(std::string_view, const std::filesystem::path&, const MeshReadOptions&);
    std::string (*print)(const Points&, const Faces&);
};

constexpr std::array<Format, 4> formats = {{{MeshFormat::Obj, ".obj", parse_obj, print_obj},
                                            {MeshFormat::Ply, ".ply", parse_ply, print_ply},
                                            {MeshFormat::Off, ".off", parse_off, print_off},
                                            {MeshFormat::Glb, ".glb", nullptr, print_glb}}};

const Format& find_format(MeshFormat format)
{
    return *std::find_if(formats.begin(), formats.end(),
                         [&](const Format& f) { return f.format == format; });
}

template <class Value>
void append(std::string& text, Value value)
{
    std::array<char, 32> digits;
    const auto result = std::to_chars(digits.data(), digits.data() + digits.size(), value);
    text.append(digits.data(), result.ptr);
}

} // namespace

void internal::append_number(std::string& text, double value)
{
    append(text, value);
}
void internal::append_number(std::string& text, int value)
{
    append(text, value);
}

void internal::check_mesh(const Points& points, const Faces& faces)
{
    for (Eigen::Index v = 0; v < points.rows(); ++v)
        if (!points.row(v).allFinite())
            throw InvalidInput(join("points: row ", v, " is (", points(v, 0), ", ", points(v, 1),
                                    ", ", points(v, 2), "), must be finite"));
    for (Eigen::Index f = 0; f < faces.rows(); ++f)
        if (faces.row(f).minCoeff() < 0 || faces.row(f).maxCoeff() >= points.rows())
            throw InvalidInput(join("faces: row ", f, " is (", faces(f, 0), ", ", faces(f, 1), ", ",
                                    faces(f, 2), "), must be in [0, ", points.rows(), ")"));
}

NamedMesh read_mesh(const std::filesystem::path& path, const MeshReadOptions& options)
{
    const Format& format = find_format(mesh_format(path));
    if (format.parse == nullptr)
        throw InvalidInput(
            join(path.string(), ": ", format.ending, " files are written, not read"));
    return format.parse(read_file(path, MeshBuilder::file_limit), path, options);
}

void write_mesh(const std::filesystem::path& path, const Points& points, const Faces& faces,
                MeshFormat format)
{
    check_mesh(points, faces);
    write_file_atomically(path, find_format(format).print(points, faces));
}

void write_mesh(const std::filesystem::path& path, const Points& points, const Faces& faces)
{
    write_mesh(path, points, faces, mesh_format(path));
}

MeshFormat mesh_format(const std::filesystem::path& path)
{
    const std::filesystem::path name = path.filename();
    std::string ending = (name.has_extension() ? name.extension() : name).string();
    std::transform(ending.begin(), ending.end(), ending.begin(),
                   [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c; });
    for (const Format& format : formats)
        if (ending == format.ending)
            return format.format;
    throw InvalidInput(join(path.string(),
                            ": the ending of a mesh file must be .obj, .ply or .off, or .glb to "
                            "write"));
}

std::string file_ending(MeshFormat format)
{
    return find_format(format).ending;
}

} // namespace shape
