// SPDX-License-Identifier: MIT

#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "libshape/io/mesh_file.h"

namespace CLI {
class App;
class Option;
} // namespace CLI

namespace shape::tools {

class Session;

/// The arguments that say where meshes go.
struct MeshOutputArguments
{
    std::string path;   ///< A file, or a directory.
    std::string format; ///< Ending without the dot, for directories; empty: ply.
};

/// Adds --format alone, for commands that have options of their own for where meshes go.
void add_mesh_format(CLI::App& command, MeshOutputArguments& arguments);

/// Adds -o, which is required and returned, and --format.
CLI::Option* add_mesh_output(CLI::App& command, MeshOutputArguments& arguments);

/// Takes the meshes of a run and keeps all of them or none: they are written beside their place and
/// renamed into it by commit(). A new directory appears as a whole.
class MeshOutput
{
public:
    /// Decides on every path and checks each as check_output().
    ///
    /// The path is a file if it has an ending, names no existing directory and does not end in a
    /// slash; only a single mesh can go into a file.
    /// @param names  Stem of each file in a directory; the format gives the ending.
    /// @param further_files  Names of other files that go into the directory with the meshes.
    /// @throws UsageError  for several meshes and one file, or an ending that is no mesh format.
    /// @throws InvalidInput  for two equal names, or one that cannot be a file name.
    MeshOutput(const Session& session, const MeshOutputArguments& arguments,
               const std::vector<std::string>& names,
               const std::vector<std::filesystem::path>& inputs,
               const std::vector<std::string>& further_files = {});
    ~MeshOutput();
    MeshOutput(const MeshOutput&) = delete;
    MeshOutput& operator=(const MeshOutput&) = delete;

    /// Writes the mesh of names[index].
    void write(std::size_t index, const Points& points, const Faces& faces);

    /// Where to write a further file until commit().
    [[nodiscard]] std::filesystem::path staged(const std::string& further_file) const;

    /// Puts what was written into its place.
    void commit();

    /// The final paths: meshes in the order of their names, then the further files.
    [[nodiscard]] std::vector<std::string> paths() const;

private:
    std::vector<std::filesystem::path> paths_;
    std::filesystem::path directory_; ///< Where the files go.
    std::filesystem::path staging_;   ///< Where they are kept until then.
    MeshFormat format_ = MeshFormat::Ply;
};

} // namespace shape::tools
