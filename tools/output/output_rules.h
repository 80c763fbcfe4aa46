// SPDX-License-Identifier: MIT

#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace CLI {
class App;
class Option;
} // namespace CLI

namespace shape::tools {

class Session;

/// Adds the required option -o for one file.
CLI::Option* add_output_file(CLI::App& command, std::string& path, const std::string& description);

/// Refuses an output before any work is done.
/// @param inputs  Files that the run reads.
/// @throws UsageError if the output is one of the inputs.
/// @throws FileError if it exists and --force is not given, it is not a regular file, or its directory
///     is missing or not writable.
void check_output(const Session& session, const std::filesystem::path& output,
                  const std::vector<std::filesystem::path>& inputs);

/// @throws UsageError if both options name one file.
void check_different(const std::string& option, const std::filesystem::path& path,
                     const std::string& other_option, const std::filesystem::path& other_path);

/// Whether the path ends so, in letters of either case.
/// @param ending  In lower case, with its dot.
[[nodiscard]] bool has_ending(const std::filesystem::path& path, std::string_view ending);

/// @throws UsageError if the path does not end so, in letters of either case.
void check_ending(const std::string& option, const std::filesystem::path& path,
                  const std::string& ending);

} // namespace shape::tools
