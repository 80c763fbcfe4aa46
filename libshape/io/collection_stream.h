// SPDX-License-Identifier: MIT

#pragma once

#include <filesystem>

#include "libshape/mesh/mesh_stream.h"

namespace shape {

/// Opens a collection file for reading mesh by mesh. Positions alone are read, each checked against
/// its checksum; lengths and angles that the file may hold for other programs are not.
/// @throws as read_collection(), but for what concerns positions, lengths and angles. Reading throws
///     FileError if the file is written to meanwhile, and InvalidInput naming the meshes if a part of
///     it is damaged or a position is not finite.
[[nodiscard]] MeshStream open_collection(const std::filesystem::path& path);

} // namespace shape
