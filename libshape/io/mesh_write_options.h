// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "libshape/io/mesh_file.h"
#include "libshape/io/obj_template.h"
#include "libshape/io/vertex_scalars.h"
#include "libshape/mesh/points.h"

namespace shape {

/// Red, green and blue of vertices, #V by 3.
using VertexColours = Eigen::Matrix<std::uint8_t, Eigen::Dynamic, 3, Eigen::RowMajor>;

/// What a mesh file holds beside the mesh, and how.
struct MeshWriteOptions
{
    /// Numbers are written as text (PLY, STL, VTK, VTP); OBJ and OFF are text always.
    bool ascii = false;
    /// Coordinates and scalars are written as float32, about 7 digits (PLY, VTK, VTP); STL and GLB are always.
    bool single_precision = false;
    /// These values are written at the vertices (PLY, VTK, VTP).
    std::vector<VertexScalar> scalars = {};
    /// The scalar of this name is written once more as `quality`, the one name that ParaView, MeshLab and
    /// Blender all show (PLY). Empty: none is.
    std::string quality = {};
    /// #V by 3: these colours are written at the vertices, in PLY as `uchar red, green, blue`, in VTK and VTP
    /// as an array `colours`. Empty: none are.
    VertexColours colours = {};
    /// All but positions and normals is taken from there (OBJ).
    std::shared_ptr<const ObjTemplate> obj_template = nullptr;
};

/// Writes a mesh as write_mesh() of mesh_file.h does, with what the options add.
/// @throws InvalidInput as write_mesh(); if the format cannot hold what an option asks for; a scalar
///     breaks a rule of VertexScalar, is named twice or as the colours are, or a name is `quality` and so
///     is asked for twice; colours are not of #V rows; the template has other faces; or a coordinate is beyond float32
///     where that is written.
/// @throws FileError if it cannot be written.
void write_mesh(const std::filesystem::path& path, const Points& points, const Faces& faces,
                MeshFormat format, const MeshWriteOptions& options);

} // namespace shape
