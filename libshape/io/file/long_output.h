// SPDX-License-Identifier: MIT

#pragma once

#include <filesystem>
#include <functional>
#include <string_view>

namespace shape::internal {

using AppendText = std::function<void(std::string_view text)>;

/// write_file_atomically() of text that is made piece by piece.
/// @param make  Called once; what it throws passes through.
/// @throws FileError as write_file_atomically(), also where a piece cannot be written.
void write_pieces_atomically(const std::filesystem::path& path,
                             const std::function<void(const AppendText& append)>& make);

} // namespace shape::internal
