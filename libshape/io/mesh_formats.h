// SPDX-License-Identifier: MIT

#pragma once

#include <cstdint>
#include <filesystem>
#include <initializer_list>
#include <string>
#include <string_view>

#include "libshape/io/mesh_file.h"
#include "libshape/io/mesh_write_options.h"

// Readers and writers of the formats, from and to memory. Internal to mesh_file.cpp: the writers
// trust their arguments, but for names that only their own format has taken.

namespace shape::internal {

/// @param path  For messages and the name of the mesh.
/// @throws as read_mesh().
[[nodiscard]] NamedMesh parse_obj(std::string_view content, const std::filesystem::path& path,
                                  const MeshReadOptions& options);
[[nodiscard]] NamedMesh parse_ply(std::string_view content, const std::filesystem::path& path,
                                  const MeshReadOptions& options);
[[nodiscard]] NamedMesh parse_off(std::string_view content, const std::filesystem::path& path,
                                  const MeshReadOptions& options);

[[nodiscard]] MeshFileContent parse_stl(std::string_view content, const std::filesystem::path& path,
                                        const MeshReadOptions& options);
[[nodiscard]] MeshFileContent parse_vtk(std::string_view content, const std::filesystem::path& path,
                                        const MeshReadOptions& options);
/// There if SHAPE_READS_VTP is defined.
[[nodiscard]] MeshFileContent parse_vtp(std::string_view content, const std::filesystem::path& path,
                                        const MeshReadOptions& options);
[[nodiscard]] MeshFileContent parse_glb(std::string_view content, const std::filesystem::path& path,
                                        const MeshReadOptions& options);

/// How many times a GLB file may use what it holds once: nodes may name one mesh, and morph targets may move nothing.
struct GlbLimits
{
    /// Vertices of a mesh and its targets, and vertices or faces that all nodes place. A file may have more of them if
    /// its buffer is so large that they may all be in it: a vertex in 12 bytes, one that is placed in 6.
    std::int64_t rows = 40'000'000;
    std::size_t meshes = 10'000; ///< What compares all takes seconds then.
};
[[nodiscard]] MeshFileContent parse_glb(std::string_view content, const std::filesystem::path& path,
                                        const MeshReadOptions& options, const GlbLimits& limits);

/// @param options  Each writer looks at what its format can hold alone.
[[nodiscard]] std::string print_obj(const Points& points, const Faces& faces,
                                    const MeshWriteOptions& options);
[[nodiscard]] std::string print_ply(const Points& points, const Faces& faces,
                                    const MeshWriteOptions& options);
[[nodiscard]] std::string print_off(const Points& points, const Faces& faces,
                                    const MeshWriteOptions& options);
[[nodiscard]] std::string print_stl(const Points& points, const Faces& faces,
                                    const MeshWriteOptions& options);
[[nodiscard]] std::string print_vtk(const Points& points, const Faces& faces,
                                    const MeshWriteOptions& options);
[[nodiscard]] std::string print_vtp(const Points& points, const Faces& faces,
                                    const MeshWriteOptions& options);
[[nodiscard]] std::string print_glb(const Points& points, const Faces& faces,
                                    const MeshWriteOptions& options);

/// The template with other positions, and normals that follow from them.
[[nodiscard]] std::string print_obj_template(const ObjTemplate& model, const Points& points);

/// @throws InvalidInput if a coordinate is not finite or a face names a missing vertex.
void check_mesh(const Points& points, const Faces& faces);

/// @throws InvalidInput if the scalars or `quality` break a rule that all formats have.
void check_scalars(const MeshWriteOptions& options, Eigen::Index vertices);

/// @param taken  What the format calls the colours.
/// @throws InvalidInput if there are colours and a scalar has one of these names.
void check_colour_names(const MeshWriteOptions& options,
                        std::initializer_list<std::string_view> taken);

/// Appends the shortest digits that give the number back.
void append_number(std::string& text, double value);
void append_number(std::string& text, float value);
void append_number(std::string& text, int value);

/// Appends the numbers of a row to `start`, one blank between all, and ends the line.
template <class Row>
void append_line(std::string& text, std::string_view start, const Row& row)
{
    text += start;
    for (const auto value : row) {
        if (!text.ends_with('\n'))
            text += ' ';
        append_number(text, value);
    }
    text += '\n';
}

} // namespace shape::internal
