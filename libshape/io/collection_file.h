// SPDX-License-Identifier: MIT

#pragma once

#include <filesystem>
#include <string>

#include "libshape/mesh/collection.h"

namespace shape {

/// Writes a collection as HDF5 (docs/formats.md): checksummed, read back and compared, then renamed
/// into place. Equal collections give equal bytes.
/// @throws FileError if it cannot be written.
void write_collection(const std::filesystem::path& path, const Collection& collection);

/// @throws FileError if the file cannot be read; LimitExceeded if it is larger than the limits.
/// @throws InvalidInput naming the dataset and the rule if it is not one of our collections, is
///     truncated or damaged, or has wrong shapes, types or values.
[[nodiscard]] Collection read_collection(const std::filesystem::path& path);

} // namespace shape
