// SPDX-License-Identifier: MIT

#pragma once

#include <filesystem>
#include <string>

#include "libshape/mesh/collection.h"
#include "libshape/mesh/points.h"

namespace shape {

/// Formats of single meshes.
enum class MeshFormat
{
    Obj,
    Ply, ///< Read: ascii and both binary orders. Written: binary little-endian, double coordinates.
    Off,
};

struct MeshReadOptions
{
    bool triangulate = false; ///< Split polygons as fans from their first corner; else refuse them.
};

/// Reads a mesh strictly: vertex and face order and double precision are kept, nothing is guessed.
/// Only syntax is checked (numbers, counts, index range); the surface itself is Topology's matter.
/// @throws FileError if the file cannot be read; LimitExceeded beyond 2 GiB.
/// @throws InvalidInput naming file, line or byte offset, and rule, for anything malformed: an
///     unknown ending, counts that disagree with the data or exceed the file's size, coordinates
///     that are missing or not finite, indices out of range, polygons without `triangulate`.
[[nodiscard]] NamedMesh read_mesh(const std::filesystem::path& path,
                                  const MeshReadOptions& options = {});

/// Writes a mesh beside the target and renames it into place; text formats with the digits that
/// give every double back.
/// @throws FileError if it cannot be written.
void write_mesh(const std::filesystem::path& path, const Points& points, const Faces& faces,
                MeshFormat format);

/// The format of an ending (".obj", ".ply", ".off", any case).
/// @throws InvalidInput for any other; the message lists those that exist.
[[nodiscard]] MeshFormat mesh_format(const std::filesystem::path& path);

/// ".obj", ".ply" or ".off".
[[nodiscard]] std::string file_ending(MeshFormat format);

} // namespace shape
