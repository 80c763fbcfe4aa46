// SPDX-License-Identifier: MIT

#include "libshape/io/vtk_values.h"

#include <algorithm>
#include <array>

#include "libshape/base/format.h"

namespace shape::internal {
namespace {

/// Two names in legacy files and one in XML files, in the order of ScalarType; VTK has no float16.
constexpr std::array<std::array<std::string_view, 3>, 11> type_names = {
    {{"char", "signed_char", "Int8"},
     {"unsigned_char", "unsigned_char", "UInt8"},
     {"short", "short", "Int16"},
     {"unsigned_short", "unsigned_short", "UInt16"},
     {"int", "int", "Int32"},
     {"unsigned_int", "unsigned_int", "UInt32"},
     {"vtktypeint64", "long", "Int64"}, // `long` as Linux has it
     {"vtktypeuint64", "unsigned_long", "UInt64"},
     {"", "", ""},
     {"float", "float", "Float32"},
     {"double", "double", "Float64"}}};

} // namespace

std::optional<ScalarType> legacy_vtk_type(std::string_view name)
{
    if (name == "vtkidtype") // written as int, whatever it is in memory
        return ScalarType::Int32;
    if (name == "vtktypeint32")
        return ScalarType::Int32;
    for (std::size_t i = 0; i < type_names.size(); ++i)
        if (!name.empty() && (name == type_names[i][0] || name == type_names[i][1]))
            return static_cast<ScalarType>(i);
    return std::nullopt;
}

std::optional<ScalarType> xml_vtk_type(std::string_view name)
{
    for (std::size_t i = 0; i < type_names.size(); ++i)
        if (!name.empty() && name == type_names[i][2])
            return static_cast<ScalarType>(i);
    return std::nullopt;
}

void add_cells(MeshBuilder& mesh, const VtkCells& cells, std::int64_t first_vertex, bool are_strips,
               const MeshBuilder::Fail& fail)
{
    const auto all = std::ssize(cells.connectivity);
    std::int64_t begin = 0;
    std::vector<std::int64_t> corners;
    for (std::size_t i = 0; i < cells.ends.size(); ++i) {
        const std::int64_t end = cells.ends[i];
        if (end < begin || end > all)
            fail(join("cell ", i, " ends at entry ", end, " of the connectivity, must be in [",
                      begin, ", ", all, "]"));
        if (!are_strips && end - begin > MeshBuilder::corner_limit)
            fail(join("a face has ", end - begin, " corners; the limit is ",
                      MeshBuilder::corner_limit));
        corners.assign(cells.connectivity.begin() + begin, cells.connectivity.begin() + end);
        for (std::int64_t& corner : corners) {
            if (corner < 0 || corner >= mesh.vertex_count() - first_vertex)
                fail(join("cell ", i, " names vertex ", corner, " of ",
                          mesh.vertex_count() - first_vertex));
            corner += first_vertex;
        }
        if (!are_strips)
            mesh.add_polygon(corners);
        else
            for (std::size_t c = 0; c + 2 < corners.size(); ++c) {
                const std::size_t turned = c % 2;
                mesh.add_polygon(std::array<std::int64_t, 3>{
                    corners[c + turned], corners[c + 1 - turned], corners[c + 2]});
            }
        begin = end;
    }
    if (begin != all)
        fail(join("the cells have ", begin, " corners, their connectivity has ", all, " entries"));
}

} // namespace shape::internal
