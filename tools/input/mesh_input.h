// SPDX-License-Identifier: MIT

#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "libshape/base/progress.h"
#include "libshape/io/mesh_file.h"
#include "libshape/mesh/collection.h"
#include "libshape/mesh/oddities.h"

namespace CLI {
class App;
}

namespace shape::tools {

class Session;

/// The arguments that name meshes, wherever a command takes MESHES.
struct MeshInput
{
    std::vector<std::string> paths; ///< Files, directories and collection files, in any mix.
    bool triangulate = false;       ///< Cut polygons into triangles.
    bool may_repeat = false;        ///< Meshes of one name are told apart by a number.
    std::string labels;             ///< CSV file with labels; empty: those of the collections.
    /// One of the meshes, as of a model, that these are compared with, and not with each other: they must have its
    /// triangulation.
    std::optional<NamedMesh> known = {};
};

/// Adds MESHES (or an option of another name that takes them) and --triangulate.
void add_mesh_input(CLI::App& command, MeshInput& input, const std::string& name = "MESHES");

/// Whether a path has the ending of a collection file.
[[nodiscard]] bool is_collection_file(const std::filesystem::path& path);

/// The files behind the arguments: a directory becomes its mesh files in natural name order (s2
/// before s10).
/// @throws FileError if a path does not exist; InvalidInput if a directory holds no mesh file.
[[nodiscard]] std::vector<std::filesystem::path> mesh_files(const MeshInput& input);

/// Where what is said while meshes are read goes, and whether reading goes on.
struct MeshNotices
{
    std::function<void(const std::string&)> message;
    std::function<void(const std::string&)> warn;
    Progress progress;
};
[[nodiscard]] MeshNotices notices_of(const Session& session);

/// Warns of files in the directories that hold meshes in formats that are not read and of subfolders that cannot be
/// looked into, and says how many mesh files lie in their subfolders and are not taken.
void note_passed_over(const MeshNotices& notices, const MeshInput& input);

/// All files that reading the input opens: mesh_files() and the file of labels.
[[nodiscard]] std::vector<std::filesystem::path> input_files(const MeshInput& input);

/// Two meshes that a table of labels takes for one (names_alike()).
struct NamesAlike
{
    std::size_t first, second;
    std::string message; ///< With their paths and what to do.
};
[[nodiscard]] std::optional<NamesAlike> find_names_alike(const std::vector<std::string>& names,
                                                         const std::vector<std::string>& paths);

/// The labels of these meshes in a file; says which of its rows and columns are left out, and warns of doubts_about() it.
[[nodiscard]] Labels labels_of(const MeshNotices& notices, const std::string& path,
                               const std::vector<std::string>& names);

/// The meshes of one file: a mesh, or the members of a collection with their labels.
struct FileContent
{
    std::vector<NamedMesh> meshes;
    Labels labels;
    bool single_precision = false;   ///< As of MeshFileContent.
    Eigen::Index merged_corners = 0; ///< Likewise.
};
[[nodiscard]] FileContent read_mesh_file(const std::filesystem::path& path, bool triangulate,
                                         PolygonCuts* cuts = nullptr);

/// What the formats of files have cost their meshes; said in a line for each kind, however many they are.
class FormatNotes
{
public:
    void add(const std::filesystem::path& path, const FileContent& content);
    void say(const MeshNotices& notices) const;

private:
    std::size_t single_ = 0;
    std::size_t merged_ = 0;
    std::string first_single_;
    std::string first_merged_; ///< And what became of it.
};

/// The message of an oddity, with the command that repairs it: the library knows none.
[[nodiscard]] std::string advice_on(const Oddity& oddity);

/// Reads everything and checks that it is in correspondence. Without a file of labels a mesh keeps
/// those of its collection file; where others have a label that it lacks, its value is empty. Warns of
/// what is odd about meshes that are not read from a single collection file (find_oddities()).
[[nodiscard]] Collection read_meshes(const MeshNotices& notices, const MeshInput& input);
[[nodiscard]] Collection read_meshes(const Session& session, const MeshInput& input);

} // namespace shape::tools
