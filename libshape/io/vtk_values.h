// SPDX-License-Identifier: MIT

#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "libshape/io/mesh_builder.h"

// What the two formats of VTK, legacy and XML, share. Internal to their readers and writers.

namespace shape::internal {

enum class VtkType
{
    Int8,
    Uint8,
    Int16,
    Uint16,
    Int32,
    Uint32,
    Int64,
    Uint64,
    Float32,
    Float64,
};

/// The type that a legacy file ("unsigned_char", "vtkIdType") or an XML file ("UInt8") names.
[[nodiscard]] std::optional<VtkType> legacy_vtk_type(std::string_view name);
[[nodiscard]] std::optional<VtkType> xml_vtk_type(std::string_view name);

[[nodiscard]] std::int64_t size_of(VtkType type); // [byte]
[[nodiscard]] bool is_integer(VtkType type);

/// The value whose first byte is given.
/// @param swap  Whether the order of its bytes is not that of this machine.
[[nodiscard]] double vtk_number(const char* bytes, VtkType type, bool swap);

/// The same of an integer type; none if it exceeds 63 bits.
[[nodiscard]] std::optional<std::int64_t> vtk_integer(const char* bytes, VtkType type, bool swap);

/// Cells as VTK keeps them: cell i has the corners connectivity[ends[i - 1] .. ends[i]), ends[-1] = 0.
struct VtkCells
{
    std::vector<std::int64_t> ends;
    std::vector<std::int64_t> connectivity;
};

/// Adds cells to the mesh.
/// @param first_vertex  What their vertex 0 is in the mesh.
/// @param are_strips  Each cell is a triangle strip, every other of whose triangles is turned over.
/// @param fail  Called if ends do not ascend to the length of the connectivity.
void add_cells(MeshBuilder& mesh, const VtkCells& cells, std::int64_t first_vertex, bool are_strips,
               const MeshBuilder::Fail& fail);

} // namespace shape::internal
