// SPDX-License-Identifier: MIT

#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace shape::test {

/// A Python with h5py; empty if there is none.
[[nodiscard]] std::string python_with_h5py();

/// Runs statements in which `f` is the file, opened by h5py, and `np` is numpy; what they print, and
/// the traceback of what they raise.
/// @param mode  "r" or "r+".
[[nodiscard]] std::string run_h5py(const std::filesystem::path& file, const std::string& mode,
                                   const std::string& statements);

/// Copies of a file, one for each entry of `edits`, on which that statement was run.
/// @throws std::runtime_error with what Python says if one fails.
[[nodiscard]] std::vector<std::filesystem::path> edit_with_h5py(
    const std::filesystem::path& file, const std::vector<std::string>& edits);

} // namespace shape::test
