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
#include "libshape/io/scalar_type.h"

// What the two formats of VTK, legacy and XML, share. Internal to their readers and writers.

namespace shape::internal {

/// The type that a legacy file ("unsigned_char", "vtkIdType") or an XML file ("UInt8") names; none for other words.
[[nodiscard]] std::optional<ScalarType> legacy_vtk_type(std::string_view name);
[[nodiscard]] std::optional<ScalarType> xml_vtk_type(std::string_view name);

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
