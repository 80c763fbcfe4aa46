// SPDX-License-Identifier: MIT

#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "libshape/mesh/collection.h"

namespace shape::tools {

/// Meshes named by an option: each text is the name of a mesh of the run, or a path as MESHES takes
/// it (a mesh file, a directory, a collection file).
struct MeshChoice
{
    std::string option; ///< For messages.
    std::vector<std::string> texts;
    bool triangulate = false;
    std::function<void(const std::string&)> warn = {}; ///< Of polygons that fold over.
};

/// The files among them, for a run that has these meshes.
/// @throws InvalidInput if a text is neither the name of one of `names` nor a path that exists.
[[nodiscard]] std::vector<std::filesystem::path> chosen_files(
    const MeshChoice& choice, const std::vector<std::string>& names);

/// The meshes, in the order of the texts.
/// @param run  The meshes of the run, if there are any.
/// @param known  One of the meshes whose triangulation is wanted, as which polygons are cut; its path is for messages.
/// @throws as chosen_files() and collect(); InvalidInput if a mesh has another triangulation, saying whether it is a mirror
///     image of the known one, inside out, or what else.
[[nodiscard]] Collection choose_meshes(const MeshChoice& choice, const Collection& run,
                                       const NamedMesh& known);

} // namespace shape::tools
