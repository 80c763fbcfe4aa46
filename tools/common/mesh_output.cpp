// SPDX-License-Identifier: MIT

#include "tools/common/mesh_output.h"

#include <unistd.h>

#include <algorithm>
#include <set>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "tools/common/arguments.h"
#include "tools/common/output_rules.h"
#include "tools/common/session.h"

namespace shape::tools {
namespace {

namespace fs = std::filesystem;

bool names_a_file(const fs::path& path)
{
    return path.has_filename() && path.has_extension() && !fs::is_directory(path);
}

MeshFormat format_of(const fs::path& path)
{
    try {
        return mesh_format(path);
    } catch (const InvalidInput& error) {
        throw UsageError(join("-o: ", error.what(), "; a directory may end in a slash"));
    }
}

void check_names(const std::vector<std::string>& names)
{
    std::set<std::string> seen;
    for (const std::string& name : names) {
        const bool usable = !name.empty() && name.front() != '.' && name.size() <= 200 &&
                            std::all_of(name.begin(), name.end(), [](unsigned char c) {
                                return c >= 0x20 && c != 0x7f && c != '/' && c != '\\';
                            });
        if (!usable)
            throw InvalidInput(join("'", name,
                                    "' cannot be the name of a mesh file: empty, longer "
                                    "than 200, starting with a dot, or with a slash or "
                                    "control character"));
        if (!seen.insert(name).second)
            throw InvalidInput(join("the mesh name '", name,
                                    "' occurs twice; every output needs "
                                    "a name of its own"));
    }
}

} // namespace

void add_mesh_format(CLI::App& command, MeshOutputArguments& arguments)
{
    command
        .add_option("--format", arguments.format,
                    "Format of the files in a directory (default: ply, binary with doubles)")
        ->check(CLI::IsMember({"obj", "ply", "off"}))
        ->option_text("obj|ply|off");
}

CLI::Option* add_mesh_output(CLI::App& command, MeshOutputArguments& arguments)
{
    add_mesh_format(command, arguments);
    return command
        .add_option("-o,--output", arguments.path,
                    "One mesh: a file (.obj .ply .off) or a directory; several: a directory.\n"
                    "A missing directory is made, its parent must exist")
        ->required()
        ->option_text("PATH REQUIRED");
}

MeshOutput::MeshOutput(const Session& session, const MeshOutputArguments& arguments,
                       const std::vector<std::string>& names, const std::vector<fs::path>& inputs,
                       const std::vector<std::string>& further_files)
{
    const fs::path path = arguments.path;
    if (names_a_file(path)) {
        format_ = format_of(path);
        if (names.size() + further_files.size() > 1)
            throw UsageError(join("-o: ", names.size() + further_files.size(), " files come out; '",
                                  path.string(), "' names one file, give a directory"));
        if (!arguments.format.empty() && mesh_format("x." + arguments.format) != format_)
            throw UsageError(join("--format ", arguments.format, " contradicts the ending of '",
                                  path.string(), "'"));
        check_output(session, path, inputs);
        paths_ = {path};
        return;
    }
    format_ = arguments.format.empty() ? MeshFormat::Ply : mesh_format("x." + arguments.format);
    directory_ = path.has_filename() ? path : path.parent_path();
    check_names(names);
    for (const std::string& name : names)
        paths_.push_back(directory_ / (name + file_ending(format_)));
    for (const std::string& file : further_files)
        paths_.push_back(directory_ / file);
    const std::string own_suffix = join(".", getpid(), ".tmp");
    if (fs::is_directory(directory_)) {
        for (const fs::path& file : paths_)
            check_output(session, file, inputs);
        staging_ = directory_ / (".shape" + own_suffix);
    } else {
        check_output(session, directory_, inputs);
        staging_ = directory_.parent_path() / ("." + directory_.filename().string() + own_suffix);
    }
}

MeshOutput::~MeshOutput()
{
    std::error_code ignored; // The run has failed already; its error is the one to report.
    if (!staging_.empty())
        fs::remove_all(staging_, ignored);
}

void MeshOutput::write(std::size_t index, const Points& points, const Faces& faces)
{
    if (!staging_.empty())
        fs::create_directory(staging_);
    const fs::path path = paths_.at(index);
    write_mesh(staging_.empty() ? path : staging_ / path.filename(), points, faces, format_);
}

fs::path MeshOutput::staged(const std::string& further_file) const
{
    return staging_ / further_file;
}

void MeshOutput::commit()
{
    if (staging_.empty())
        return;
    if (fs::is_directory(directory_))
        for (const fs::path& path : paths_)
            fs::rename(staging_ / path.filename(), path);
    else
        fs::rename(staging_, directory_);
}

std::vector<std::string> MeshOutput::paths() const
{
    return {paths_.begin(), paths_.end()};
}

} // namespace shape::tools
