// SPDX-License-Identifier: MIT

#pragma once

#include <filesystem>
#include <functional>
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

/// An edit that makes a file one to be refused, and what the message says.
struct BadEdit
{
    std::string edit;
    std::string place; ///< Stands behind the name of the file.
    std::string rule;  ///< Somewhere in the message.
};

/// Expects InvalidInput, with such a message, from reading a copy of the file after each edit.
void expect_refused(const std::filesystem::path& file, const std::vector<BadEdit>& edits,
                    const std::function<void(const std::filesystem::path&)>& read);

} // namespace shape::test
