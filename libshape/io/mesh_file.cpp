// SPDX-License-Identifier: MIT

#include "libshape/io/mesh_file.h"

#include <algorithm>
#include <array>
#include <charconv>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/letter_case.h"
#include "libshape/io/file/input_file.h"
#include "libshape/io/file/output_file.h"
#include "libshape/io/mesh_builder.h"
#include "libshape/io/mesh_formats.h"
#include "libshape/mesh/other_diagonals.h"

namespace shape {
using namespace internal;
namespace {

/// A reader of one mesh as one of files with several.
template <NamedMesh (*parse)(std::string_view, const std::filesystem::path&,
                             const MeshReadOptions&)>
MeshFileContent parse_one(std::string_view content, const std::filesystem::path& path,
                          const MeshReadOptions& options)
{
    return {.meshes = {parse(content, path, options)}};
}

#ifndef SHAPE_READS_VTP
MeshFileContent refuse_vtp(std::string_view, const std::filesystem::path& path,
                           const MeshReadOptions&)
{
    throw InvalidInput(join(path.string(),
                            ": this build does not read .vtp files; build it anew with the "
                            "package libpugixml-dev, or save as legacy .vtk"));
}
#define parse_vtp refuse_vtp
#endif

struct Format
{
    MeshFormat format;
    const char* ending;
    MeshFileContent (*parse)(std::string_view, const std::filesystem::path&,
                             const MeshReadOptions&);
    std::string (*print)(const Points&, const Faces&, const MeshWriteOptions&);
    bool has_text = false;    ///< As well as bytes.
    bool has_scalars = false; ///< And colours, and both precisions.
    bool is_single = false;   ///< In bytes or in text.
};

constexpr std::array<Format, 7> formats = {
    {{MeshFormat::Obj, ".obj", parse_one<parse_obj>, print_obj},
     {MeshFormat::Ply, ".ply", parse_one<parse_ply>, print_ply, true, true},
     {MeshFormat::Off, ".off", parse_one<parse_off>, print_off},
     {MeshFormat::Stl, ".stl", parse_stl, print_stl, true, false, true},
     {MeshFormat::Vtk, ".vtk", parse_vtk, print_vtk, true, true},
     {MeshFormat::Vtp, ".vtp", parse_vtp, print_vtp, true, true},
     {MeshFormat::Glb, ".glb", parse_glb, print_glb, false, false, true}}};

const Format& find_format(MeshFormat format)
{
    return *std::find_if(formats.begin(), formats.end(),
                         [&](const Format& f) { return f.format == format; });
}

/// Whether a template has these faces, its polygons cut as they are if need be.
bool has_faces(const ObjTemplate& model, const Points& points, const Faces& faces)
{
    const auto are_these = [&](const Faces& others) {
        return others.rows() == faces.rows() && others == faces;
    };
    if (are_these(model.faces))
        return true;
    PolygonCuts cuts;
    add_triangulation(cuts, {"", "", points, faces});
    return model.faces.rows() == faces.rows() &&
           are_these(parse_obj(model.text, "", {.triangulate = true, .cuts = &cuts}).faces);
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
void internal::append_number(std::string& text, float value)
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

MeshFileContent read_mesh_members(const std::filesystem::path& path, const MeshReadOptions& options)
{
    const Format& format = find_format(mesh_format(path));
    PolygonCuts* const cuts = options.cuts;
    const std::size_t cut_before = cuts != nullptr ? cuts->cut_meshes : 0;
    MeshFileContent content = format.parse(read_file(path, MeshBuilder::file_limit), path, options);
    if (cuts != nullptr && options.triangulate)
        for (const NamedMesh& mesh : content.meshes)
            add_triangulation(*cuts, mesh, cuts->cut_meshes > cut_before);
    return content;
}

void add_triangulation(PolygonCuts& cuts, const NamedMesh& mesh, bool is_cut)
{
    constexpr std::size_t most = 16; // kinds of meshes that are read together
    const auto is_known = [&](const KnownTriangulation& known) {
        return known.vertices == mesh.points.rows() && known.faces.rows() == mesh.faces.rows() &&
               known.faces == mesh.faces;
    };
    if (cuts.known.size() < most && std::ranges::none_of(cuts.known, is_known))
        cuts.known.push_back({mesh.faces, mesh.points.rows(), mesh.path, is_cut});
}

std::optional<PolygonCuts> better_cuts(const PolygonCuts& cuts)
{
    if (cuts.known.empty() || !cuts.known.front().is_cut)
        return std::nullopt;
    const KnownTriangulation& first = cuts.known.front();
    for (const KnownTriangulation& other : cuts.known)
        if (!other.is_cut && other.vertices == first.vertices &&
            other_diagonals(first.faces, other.faces))
            return PolygonCuts{.known = {other}, .cut_meshes = 0, .folded = {}};
    return std::nullopt;
}

NamedMesh read_mesh(const std::filesystem::path& path, const MeshReadOptions& options)
{
    MeshFileContent content = read_mesh_members(path, options);
    if (content.meshes.size() > 1)
        throw InvalidInput(join(path.string(), ": holds ", content.meshes.size(), " meshes, '",
                                content.meshes[0].name, "', '", content.meshes[1].name,
                                "', ...; one is wanted here"));
    return std::move(content.meshes.front());
}

void write_mesh(const std::filesystem::path& path, const Points& points, const Faces& faces,
                MeshFormat format)
{
    write_mesh(path, points, faces, format, {});
}

void write_mesh(const std::filesystem::path& path, const Points& points, const Faces& faces,
                MeshFormat format, const MeshWriteOptions& options)
{
    const Format& rules = find_format(format);
    const auto refuse = [&](bool is_refused, const char* what, const char* formats_that_can) {
        if (is_refused)
            throw InvalidInput(
                join(rules.ending, " files have no ", what, "; ", formats_that_can, " have"));
    };
    const bool is_text_always = format == MeshFormat::Obj || format == MeshFormat::Off;
    refuse(options.ascii && !rules.has_text && !is_text_always, "form as text", "all others");
    refuse(options.single_precision && !rules.has_scalars && !rules.is_single, "single precision",
           ".ply, .vtk, .vtp, .stl and .glb");
    refuse(!options.scalars.empty() && !rules.has_scalars, "values at vertices",
           ".ply, .vtk and .vtp");
    refuse(options.colours.rows() > 0 && !rules.has_scalars, "colours of vertices",
           ".ply, .vtk and .vtp");
    refuse(!options.quality.empty() && format != MeshFormat::Ply, "property `quality`",
           ".ply files");
    refuse(options.obj_template != nullptr && format != MeshFormat::Obj, "template", ".obj files");
    check_mesh(points, faces);
    check_scalars(options, points.rows());
    if (options.colours.rows() > 0 && options.colours.rows() != points.rows())
        throw InvalidInput(join("colours has ", options.colours.rows(), " rows, the mesh has ",
                                points.rows(), " vertices"));
    if ((options.single_precision || rules.is_single) && !points.cast<float>().allFinite())
        throw InvalidInput("points: a coordinate is beyond single precision");
    if (options.obj_template != nullptr && !has_faces(*options.obj_template, points, faces))
        throw InvalidInput(
            "the template has other faces than the mesh; it must be the OBJ file that the meshes "
            "were made from, or one of the same faces in the same order");
    write_file_atomically(path, rules.print(points, faces, options));
}

void write_mesh(const std::filesystem::path& path, const Points& points, const Faces& faces)
{
    write_mesh(path, points, faces, mesh_format(path));
}

MeshFormat mesh_format(const std::filesystem::path& path)
{
    const std::filesystem::path name = path.filename();
    const std::string ending =
        lower_case((name.has_extension() ? name.extension() : name).string());
    for (const Format& format : formats)
        if (ending == format.ending)
            return format.format;
    throw InvalidInput(join(path.string(),
                            ": the ending of a mesh file must be .obj, .ply, .off, .stl, .vtk, "
                            ".vtp or .glb",
                            ending == ".hdf5" || ending == ".hdf" || ending == ".he5"
                                ? "; that of a collection or model of libshape is .h5"
                                : ""));
}

std::string file_ending(MeshFormat format)
{
    return find_format(format).ending;
}

} // namespace shape
