// SPDX-License-Identifier: MIT

#pragma once

#include <filesystem>

#include "libshape/base/progress.h"
#include "libshape/mesh/collection.h"
#include "libshape/mesh/mesh_stream.h"

namespace shape {

struct CollectionFileOptions
{
    /// Edge lengths and dihedral angles are written too, for other programs: three times as large.
    bool derived = false;
    /// Positions (and what is derived) are compressed without loss, by shuffle and deflate, below the
    /// checksum: about four fifths as large, several times as slow to write.
    bool compress = false;
};

/// Writes a collection as HDF5 (docs/formats.md): checksummed, read back and compared, then renamed
/// into place. Equal collections give equal bytes.
/// @throws InvalidInput if a mesh has another number of vertices, a coordinate that is not finite or
///     an edge of length 0; a name occurs twice; a text is not UTF-8, holds a NUL or has more than
///     4096 bytes; a label column is named "", "." or with a '/'.
/// @throws FileError if it cannot be written.
void write_collection(const std::filesystem::path& path, const Collection& collection,
                      const CollectionFileOptions& options = {});

/// The same of meshes that are read while they are written, each once (with `derived`, three times).
/// @param progress  Called with meshes written.
void write_collection(const std::filesystem::path& path, const MeshStream& meshes,
                      const CollectionFileOptions& options = {}, const Progress& progress = {});

/// Replaces a collection file by one of its meshes and of others after them: what is there is copied,
/// not measured or checked again. Equal bytes to a collection that was written of all of them at once.
/// @param options  In addition to those that the file was written with, which it keeps.
/// @param progress  Called with meshes written.
/// @return The number of meshes that the file now has.
/// @throws as open_collection(), joined() and write_collection(); then the file is as it was.
/// @throws FileError  also if the file was replaced or written to since it was opened here.
Eigen::Index append_to_collection(const std::filesystem::path& path, const MeshStream& added,
                                  const CollectionFileOptions& options = {},
                                  const Progress& progress = {});

/// @throws FileError if the file cannot be read; LimitExceeded if it is larger than the limits.
/// @throws InvalidInput naming the dataset and the rule if it is not a collection of libshape
///     (WrongFileKind, model_file.h), is truncated or damaged, or has wrong shapes, types or values.
[[nodiscard]] Collection read_collection(const std::filesystem::path& path);

} // namespace shape
