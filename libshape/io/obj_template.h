// SPDX-License-Identifier: MIT

#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "libshape/mesh/points.h"

namespace shape {

/// An OBJ file whose texture coordinates, materials, groups and polygons other meshes of the same
/// faces are written with.
struct ObjTemplate
{
    std::string text; ///< The file.
    Faces faces;      ///< Polygons cut as read_mesh() does; they are as well cut as the meshes are.
};

/// Reads a template.
/// @param output_folder  Where the meshes go: a material library that lies beside the template is named
///     from there.
/// @throws as read_mesh() with `triangulate`; InvalidInput, too, if the path does not end in .obj or a
///     statement is continued by a backslash.
[[nodiscard]] ObjTemplate read_obj_template(const std::filesystem::path& path,
                                            const std::filesystem::path& output_folder);

} // namespace shape
