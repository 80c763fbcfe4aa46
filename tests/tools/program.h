// SPDX-License-Identifier: MIT

#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "libshape/mesh/collection.h"
#include "tests/support/files.h"

namespace shape::test {

using Arguments = std::vector<std::string>;

/// One list of arguments and then another.
[[nodiscard]] inline Arguments operator+(Arguments a, const Arguments& b)
{
    a.insert(a.end(), b.begin(), b.end());
    return a;
}

/// What a run of the program left behind.
struct Outcome
{
    int exit_code = -1; ///< 128 + signal if a signal ended it.
    std::string out;    ///< stdout.
    std::string err;    ///< stderr.
};

/// How the program is run.
struct Launch
{
    std::string interrupt_at_file = {}; ///< SIGINT is sent when this file of the folder exists,
    bool interrupt_at_change = false;   ///< or when the folder has an entry that it had not,
    bool interrupt_at_message = false;  ///< or when something is said on stderr,
    bool interrupt_when_caught = false; ///< or as soon as the program would catch it.
    bool close_stdout = false;          ///< stdout is a pipe that nobody reads.
    std::vector<std::string> environment = {}; ///< NAME=VALUE, added to that of the test.
    std::size_t largest_file = 0;              ///< > 0: writing beyond this many bytes fails.
    std::size_t address_space = 0;             ///< > 0: no more bytes can be mapped.
    std::string input_file = {};               ///< Of the folder: stdin reads it.
    /// Permissions hold for root too; exit code 127 where root cannot give up what it may.
    bool as_ordinary_user = false;
};

/// Runs the program in a folder; ends it after a minute.
[[nodiscard]] Outcome run_shape(const std::filesystem::path& folder, const Arguments& arguments,
                                const Launch& launch = {});

/// A new empty folder that goes when the object does.
class Folder : public TemporaryDirectory
{
public:
    /// Makes the directories on the way as well.
    void write(const std::string& name, std::string_view content) const;
    [[nodiscard]] std::string read(const std::string& name) const;
    [[nodiscard]] bool has(const std::string& name) const;

    /// Every file and directory below, and what is in the files.
    [[nodiscard]] std::map<std::string, std::string> content() const;
};

/// Files that a suite's tests all begin with: made once, in a folder of their own.
class MadeOnce
{
public:
    explicit MadeOnce(const std::function<void(const Folder&)>& make);

    void copy_into(const Folder& folder) const;

private:
    std::map<std::string, std::string> content_; ///< Folder::content()
};

/// Runs what makes such files.
/// @throws std::runtime_error with what is said on stderr unless it succeeds.
void run_or_throw(const Folder& folder, const Arguments& arguments);

/// Three spheres with different bumps and 42 vertices, as a.ply, b.ply and c.ply; and labels.csv
/// with the columns subject (x, x, y) and mood (calm, glad, calm).
void write_bumpy_spheres(const Folder& folder);

/// The number of lines in a text; a last one without an end counts.
[[nodiscard]] int line_count(std::string_view text);

/// The names of a directory's files, sorted.
[[nodiscard]] std::vector<std::string> files_in(const std::filesystem::path& directory);

} // namespace shape::test
