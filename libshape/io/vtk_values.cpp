// SPDX-License-Identifier: MIT

#include "libshape/io/vtk_values.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <limits>

#include "libshape/base/format.h"
#include "libshape/base/to_size.h"

namespace shape::internal {
namespace {

/// Names in legacy and in XML files, in the order of VtkType.
constexpr std::array<std::array<std::string_view, 3>, 10> type_names = {
    {{"char", "signed_char", "Int8"},
     {"unsigned_char", "unsigned_char", "UInt8"},
     {"short", "short", "Int16"},
     {"unsigned_short", "unsigned_short", "UInt16"},
     {"int", "int", "Int32"},
     {"unsigned_int", "unsigned_int", "UInt32"},
     {"vtktypeint64", "long", "Int64"}, // `long` as Linux has it
     {"vtktypeuint64", "unsigned_long", "UInt64"},
     {"float", "float", "Float32"},
     {"double", "double", "Float64"}}};
constexpr std::array<std::int64_t, 10> type_sizes = {1, 1, 2, 2, 4, 4, 8, 8, 4, 8};

template <class Value>
Value value_at(const char* bytes, bool swap)
{
    std::array<char, sizeof(Value)> copy;
    std::memcpy(copy.data(), bytes, sizeof(Value));
    if (swap)
        std::reverse(copy.begin(), copy.end());
    return std::bit_cast<Value>(copy);
}

} // namespace

std::optional<VtkType> legacy_vtk_type(std::string_view name)
{
    if (name == "vtkIdType") // written as int, whatever it is in memory
        return VtkType::Int32;
    if (name == "vtktypeint32")
        return VtkType::Int32;
    for (std::size_t i = 0; i < type_names.size(); ++i)
        if (name == type_names[i][0] || name == type_names[i][1])
            return static_cast<VtkType>(i);
    return std::nullopt;
}

std::optional<VtkType> xml_vtk_type(std::string_view name)
{
    for (std::size_t i = 0; i < type_names.size(); ++i)
        if (name == type_names[i][2])
            return static_cast<VtkType>(i);
    return std::nullopt;
}

std::int64_t size_of(VtkType type)
{
    return type_sizes[static_cast<std::size_t>(type)];
}

bool is_integer(VtkType type)
{
    return type < VtkType::Float32;
}

double vtk_number(const char* bytes, VtkType type, bool swap)
{
    if (type == VtkType::Float32)
        return value_at<float>(bytes, swap);
    if (type == VtkType::Float64)
        return value_at<double>(bytes, swap);
    if (type == VtkType::Uint64)
        return static_cast<double>(value_at<std::uint64_t>(bytes, swap));
    return static_cast<double>(*vtk_integer(bytes, type, swap));
}

std::optional<std::int64_t> vtk_integer(const char* bytes, VtkType type, bool swap)
{
    switch (type) {
        case VtkType::Int8:
            return value_at<std::int8_t>(bytes, swap);
        case VtkType::Uint8:
            return value_at<std::uint8_t>(bytes, swap);
        case VtkType::Int16:
            return value_at<std::int16_t>(bytes, swap);
        case VtkType::Uint16:
            return value_at<std::uint16_t>(bytes, swap);
        case VtkType::Int32:
            return value_at<std::int32_t>(bytes, swap);
        case VtkType::Uint32:
            return value_at<std::uint32_t>(bytes, swap);
        case VtkType::Int64:
            return value_at<std::int64_t>(bytes, swap);
        case VtkType::Uint64: {
            const auto value = value_at<std::uint64_t>(bytes, swap);
            if (value > static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max()))
                return std::nullopt;
            return static_cast<std::int64_t>(value);
        }
        default:
            return std::nullopt;
    }
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
