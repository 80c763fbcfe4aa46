// SPDX-License-Identifier: MIT

#include "libshape/io/mesh_file.h"

#include <algorithm>
#include <array>
#include <charconv>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/io/input_file.h"
#include "libshape/io/mesh_formats.h"
#include "libshape/io/output_file.h"

namespace shape {
namespace {

constexpr std::uint64_t largest_file = std::uint64_t{2} << 30;

struct Format
{
    MeshFormat format;
    const char* ending;
    NamedMesh (*parse)(std::string_view, const std::filesystem::path&, const MeshReadOptions&);
    std::string (*print)(const Points&, const Faces&);
};

constexpr std::array<Format, 3> formats = {{{MeshFormat::Obj, ".obj", parse_obj, print_obj},
                                            {MeshFormat::Ply, ".ply", parse_ply, print_ply},
                                            {MeshFormat::Off, ".off", parse_off, print_off}}};

const Format& find_format(MeshFormat format)
{
    return *std::find_if(formats.begin(), formats.end(),
                         [&](const Format& f) { return f.format == format; });
}

void check_mesh(const Points& points, const Faces& faces)
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

template <class Value>
void append(std::string& text, Value value)
{
    std::array<char, 32> digits;
    const auto result = std::to_chars(digits.data(), digits.data() + digits.size(), value);
    text.append(digits.data(), result.ptr);
}

} // namespace

void append_number(std::string& text, double value)
{
    append(text, value);
}
void append_number(std::string& text, int value)
{
    append(text, value);
}

NamedMesh read_mesh(const std::filesystem::path& path, const MeshReadOptions& options)
{
    const Format& format = find_format(mesh_format(path));
    return format.parse(read_file(path, largest_file), path, options);
}

void write_mesh(const std::filesystem::path& path, const Points& points, const Faces& faces,
                MeshFormat format)
{
    check_mesh(points, faces);
    write_file_atomically(path, find_format(format).print(points, faces));
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
    throw InvalidInput(
        join(path.string(), ": the ending of a mesh file must be .obj, .ply or .off"));
}

std::string file_ending(MeshFormat format)
{
    return find_format(format).ending;
}

} // namespace shape
