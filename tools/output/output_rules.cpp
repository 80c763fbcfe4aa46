// SPDX-License-Identifier: MIT

#include "tools/output/output_rules.h"

#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/letter_case.h"
#include "tools/program/arguments.h"
#include "tools/program/session.h"

namespace shape::tools {
using namespace internal;

namespace fs = std::filesystem;

CLI::Option* add_output_file(CLI::App& command, std::string& path, const std::string& description)
{
    return command.add_option("-o,--output", path, description)
        ->required()
        ->option_text("FILE REQUIRED");
}

void check_output(const Session& session, const fs::path& output,
                  const std::vector<fs::path>& inputs)
{
    if (output.empty())
        throw UsageError("the name of an output is empty");
    const fs::path directory = output.has_parent_path() ? output.parent_path() : fs::path(".");
    if (!fs::is_directory(directory))
        throw FileError(
            join(output.string(), ": the directory ", directory.string(), " does not exist"));
    if (access(directory.c_str(), W_OK | X_OK) != 0)
        throw FileError(join(output.string(), ": cannot write into ", directory.string(), ": ",
                             std::strerror(errno)));
    if (!fs::exists(fs::symlink_status(output))) {
        if (!session.force)
            session.free_places->add(output);
        return;
    }
    for (const fs::path& input : inputs)
        if (fs::exists(output) && fs::exists(input) && fs::equivalent(output, input))
            throw UsageError(join(output.string(), ": the output is an input of the run"));
    if (!fs::is_regular_file(output))
        throw FileError(join(output.string(), ": exists and is not a regular file"));
    check_not_protected(output);
    if (!session.force)
        throw FileError(join(output.string(), ": exists; --force overwrites it"));
}

void check_not_protected(const fs::path& output)
{
    const fs::file_status status = fs::status(output);
    if (fs::is_regular_file(status) &&
        (status.permissions() & fs::perms::owner_write) == fs::perms::none)
        throw FileError(join(output.string(),
                             ": exists and is write-protected, which --force leaves alone; `chmod "
                             "u+w` it first or name another output"));
}

void check_different(const std::string& option, const fs::path& path,
                     const std::string& other_option, const fs::path& other_path)
{
    const auto resolved = [](const fs::path& name) {
        return fs::weakly_canonical(fs::absolute(name));
    };
    if (resolved(path) == resolved(other_path))
        throw UsageError(join(option, ": '", path.string(), "' is the file of ", other_option));
}

bool names_a_file(const fs::path& path)
{
    return path.has_filename() && path.has_extension() && !fs::is_directory(path);
}

void refuse_file(const std::string& rule)
{
    throw UsageError(join(rule, "; a directory may end in a slash"));
}

bool has_ending(const fs::path& path, std::string_view ending)
{
    return lower_case(path.extension().string()) == ending;
}

void check_ending(const std::string& option, const fs::path& path, const std::string& ending)
{
    if (!has_ending(path, ending))
        throw UsageError(join(option, ": '", path.string(), "' must end in ", ending));
}

} // namespace shape::tools
