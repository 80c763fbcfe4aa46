// SPDX-License-Identifier: MIT

#pragma once

#include <filesystem>
#include <string>
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

/// @throws UsageError if the path does not end so.
void check_ending(const std::string& option, const std::filesystem::path& path,
                  const std::string& ending);

} // namespace shape::tools
