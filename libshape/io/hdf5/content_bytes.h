// SPDX-License-Identifier: MIT

#pragma once

#include <optional>
#include <string>

#include "libshape/io/hdf5/file_content.h"

namespace shape::internal {

/// All but FileContent::values, for a process of the same program.
[[nodiscard]] std::string to_bytes(const FileContent& content);

/// @returns nothing if the bytes are not those of a content.
[[nodiscard]] std::optional<FileContent> from_bytes(const std::string& bytes);

} // namespace shape::internal
