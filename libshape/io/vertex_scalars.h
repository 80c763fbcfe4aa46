// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "libshape/mesh/points.h"

namespace shape {

/// A number at every vertex of a mesh.
struct VertexScalar
{
    std::string name;       ///< Letters, digits and _, not starting with a digit; not x, y or z.
    Eigen::VectorXd values; ///< #V, finite.
};

/// Writes a mesh as write_mesh() does, with one further `double` property of its vertices for each scalar,
/// in their order. Other programs colour the mesh by them; read_mesh() skips them. PLY has the first once
/// more as `quality`, the name that most programs look for.
/// @param path  .ply, .vtk or .vtp.
/// @throws InvalidInput as write_mesh(), and if a scalar breaks a rule above or a name occurs twice.
/// @throws FileError if it cannot be written.
void write_vertex_scalars(const std::filesystem::path& path, const Points& points,
                          const Faces& faces, const std::vector<VertexScalar>& scalars);

/// Reads a property of the vertices of a PLY file, of any scalar type, #V values; x, y and z are such as well.
/// @throws as read_mesh() with `triangulate`; InvalidInput, too, if the file is not a PLY file, has no
///     such property (the message says which it has), or a value is not finite.
[[nodiscard]] Eigen::VectorXd read_vertex_scalar(const std::filesystem::path& path,
                                                 std::string_view name);

/// The same; NaN where a value is not finite, or in text stands for none as label_value() says: so programs mark
/// vertices that have no value.
[[nodiscard]] Eigen::VectorXd read_vertex_scalar_with_gaps(const std::filesystem::path& path,
                                                           std::string_view name);

/// The same of the faces, #F values: the triangles of a polygon share its value.
[[nodiscard]] Eigen::VectorXd read_face_scalar(const std::filesystem::path& path,
                                               std::string_view name);

} // namespace shape
