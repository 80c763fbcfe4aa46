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

/// Refuses an output before any work is done; of one that is not there yet, what appears until it is written is not
/// replaced without --force either (FreePlaces).
/// @param inputs  Files that the run reads.
/// @throws UsageError if the output is one of the inputs.
/// @throws FileError if it exists and --force is not given or as check_not_protected(), it is not a regular file, or
///     its directory is missing or not writable.
void check_output(const Session& session, const std::filesystem::path& output,
                  const std::vector<std::filesystem::path>& inputs);

/// For what is replaced: the mode of a file holds for root too, and a file that is renamed into its place needs none.
/// @throws FileError if the file exists and its owner may not write to it.
void check_not_protected(const std::filesystem::path& output);

/// @throws UsageError if both options name one file.
void check_different(const std::string& option, const std::filesystem::path& path,
                     const std::string& other_option, const std::filesystem::path& other_path);

/// Whether a path is that of a file, where a command writes a file or a directory: it has an ending, does not end in a
/// slash and names no directory that is there.
[[nodiscard]] bool names_a_file(const std::filesystem::path& path);

/// Refuses a path that names_a_file(), where no file can come out, or none with this ending.
/// @throws UsageError always: the rule that is broken, and that a directory may end in a slash.
[[noreturn]] void refuse_file(const std::string& rule);

/// Whether the path ends so, in letters of either case.
/// @param ending  In lower case, with its dot.
[[nodiscard]] bool has_ending(const std::filesystem::path& path, std::string_view ending);

/// @throws UsageError if the path does not end so, in letters of either case.
void check_ending(const std::string& option, const std::filesystem::path& path,
                  const std::string& ending);

} // namespace shape::tools
