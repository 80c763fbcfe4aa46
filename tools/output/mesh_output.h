// SPDX-License-Identifier: MIT

#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "libshape/io/gltf_file.h"
#include "libshape/io/mesh_file.h"
#include "libshape/io/mesh_write_options.h"

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
    bool ascii = false;
    bool single_precision = false;
    std::string template_file; ///< OBJ; empty: none.
    std::string colours;       ///< Scalar that meshes with values are coloured by; empty: none.
    std::optional<double> frames_per_second; ///< An animation shows this many.
    std::optional<double>
        glb_tolerance; ///< Frames of an animation may err by this, relative to the diagonal.
};

/// Adds --format, --ascii, --float, --template and --colors alone, for commands that have options of their own for where meshes go.
void add_mesh_format(CLI::App& command, MeshOutputArguments& arguments);

/// Adds -o, which is required and returned, and those.
CLI::Option* add_mesh_output(CLI::App& command, MeshOutputArguments& arguments);

/// Adds --fps and --glb-tolerance: for commands whose meshes are a sequence.
void add_animation_options(CLI::App& command, MeshOutputArguments& arguments);

/// Writes a mesh with values at its vertices.
/// @param colours  Name of the scalar that it is coloured by, "first" for the first, or empty.
/// @throws as MeshOutput::write_scalars().
void write_with_colours(const std::filesystem::path& path, const Points& points, const Faces& faces,
                        std::vector<VertexScalar> scalars, const std::string& colours,
                        MeshWriteOptions options = {});

/// Takes the meshes of a run and keeps all of them or none: they are written beside their place and
/// renamed into it by commit(). A new directory appears as a whole.
class MeshOutput
{
public:
    /// Decides on every path and checks each as check_output().
    ///
    /// The path is a file if it has an ending, names no existing directory and does not end in a
    /// slash. Only a single mesh can go into a file, or several as the animation of a .glb file.
    /// @param names  Stem of each file in a directory, with '_' for what a file name may not hold; the
    ///     format gives the ending.
    /// @param further_files  Names of other files that go into the directory with the meshes.
    /// @throws UsageError  for several meshes and one file, an ending that is not a mesh format, or
    ///     options of an animation without one.
    /// @throws InvalidInput  for two equal names.
    MeshOutput(const Session& session, const MeshOutputArguments& arguments,
               const std::vector<std::string>& names,
               const std::vector<std::filesystem::path>& inputs,
               const std::vector<std::string>& further_files = {});
    ~MeshOutput();
    MeshOutput(const MeshOutput&) = delete;
    MeshOutput& operator=(const MeshOutput&) = delete;

    /// From now on a companion goes with every mesh: the file in this folder beside it whose name is
    /// its stem and this suffix; a folder of its own, so that the meshes alone are a collection.
    /// Checks the companions' paths as the constructor does those of the meshes.
    /// @throws UsageError  if the output is an animation.
    void add_companions(const std::string& folder, const std::string& suffix);

    /// The ending of files of meshes with values at their vertices: that of the meshes if it can hold
    /// them, else .ply.
    [[nodiscard]] std::string scalar_ending() const;

    /// Writes a mesh with values at its vertices, with the colours that are asked for, if any.
    /// @throws UsageError  if they are to be of a scalar that is not among these.
    void write_scalars(const std::filesystem::path& path, const Points& points, const Faces& faces,
                       std::vector<VertexScalar> scalars) const;

    /// Writes the mesh of names[index]; meshes of an animation come in order.
    void write(std::size_t index, const Points& points, const Faces& faces);

    /// Where to write a further file, or the companion of a mesh, until commit().
    [[nodiscard]] std::filesystem::path staged(const std::string& further_file) const;
    [[nodiscard]] std::filesystem::path staged_companion(std::size_t index) const;

    /// Puts what was written into its place.
    void commit();

    /// The final paths: meshes in the order of their names, then the further files.
    [[nodiscard]] std::vector<std::string> paths() const;

    /// What commit() has written, if it was an animation.
    [[nodiscard]] const std::optional<GlbAnimation>& animation() const { return animation_; }

private:
    void check_paths(std::size_t first) const;
    void note_other_meshes() const;
    void prepare_writing(const MeshOutputArguments& arguments, const std::filesystem::path& folder);
    void prepare_animation(const MeshOutputArguments& arguments, std::size_t meshes);

    const Session& session_;
    std::vector<std::filesystem::path> inputs_;
    std::vector<std::filesystem::path> paths_;
    std::filesystem::path directory_; ///< Where the files go.
    bool takes_directory_ = false;    ///< It was asked for, not a file in it.
    bool makes_directory_ = false;    ///< It was not there.
    std::filesystem::path staging_;   ///< Where they are kept until then.
    MeshFormat format_ = MeshFormat::Ply;
    MeshWriteOptions write_options_;
    std::string colours_;
    std::size_t mesh_count_ = 0;
    std::size_t first_companion_ = 0; ///< Into paths_.

    bool is_animation_ = false;
    GlbAnimationOptions animation_options_;
    std::vector<Points> frames_; ///< An animation keeps its frames until commit().
    Faces faces_;
    std::optional<GlbAnimation> animation_;
};

} // namespace shape::tools
