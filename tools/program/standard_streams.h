// SPDX-License-Identifier: MIT

#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace shape::tools {

/// Lets `-` stand for standard input, and after an option of an output for standard output. What comes
/// in is spooled into a file of a private directory, what goes out is written there and copied
/// once all of it is done: commands know files alone, and a run that fails prints nothing.
class StandardStreams
{
public:
    /// Replaces every argument `-` (or `--option=-`) by the path of such a file.
    /// @param command_ending  What -o of the command writes, such as ".csv".
    /// @throws UsageError if an input or an output is `-` twice, or --json would go to the same place.
    /// @throws FileError, LimitExceeded as reading standard input fails or goes beyond 2 GiB.
    StandardStreams(std::vector<std::string> arguments, const std::string& command_ending);
    ~StandardStreams();
    StandardStreams(const StandardStreams&) = delete;
    StandardStreams& operator=(const StandardStreams&) = delete;

    [[nodiscard]] const std::vector<std::string>& arguments() const { return arguments_; }

    /// The content of the output, if one was asked for and written; to be printed.
    [[nodiscard]] std::string output() const;

    /// A text for people: `-` instead of the paths of the files.
    [[nodiscard]] std::string readable(std::string text) const;

private:
    std::filesystem::path file(const std::string& name);

    std::vector<std::string> arguments_;
    std::filesystem::path directory_; ///< Empty if there is none.
    std::filesystem::path input_;
    std::filesystem::path output_;
};

} // namespace shape::tools
