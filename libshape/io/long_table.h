// SPDX-License-Identifier: MIT

#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace shape {

/// write_table() of rows that are made one after the other and need not fit into memory.
/// @param make_rows  Called once with a function that takes a row of as many cells as columns.
/// @throws as write_table(), and what make_rows() throws.
void write_long_table(
    const std::filesystem::path& path, const std::vector<std::string>& columns,
    const std::function<
        void(const std::function<void(const std::vector<std::string>& cells)>& add)>& make_rows);

} // namespace shape
