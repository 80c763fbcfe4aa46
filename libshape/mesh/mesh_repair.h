// SPDX-License-Identifier: MIT

#pragma once

#include <string>
#include <vector>

#include "libshape/mesh/collection.h"

namespace shape {

/// What becomes of a surface in several pieces.
enum class Components
{
    KeepLargest, ///< That with the most faces, the first of equal ones.
    Split,       ///< Each piece becomes a mesh of its own, NAME_part1 and so on, in order of faces.
};

struct MeshRepairOptions
{
    Components components = Components::KeepLargest; ///< A surface in several pieces is treated so.
};

/// Meshes made from others, and what was done.
struct RepairedMeshes
{
    std::vector<NamedMesh> meshes;
    std::vector<std::string> changes; ///< A sentence each, naming the meshes.
    std::vector<std::string> kept;    ///< The same of sizes that stay odd, and why.
};

/// Repairs what can be repaired without a guess about the shape. In this order:
/// 1. a mesh with the faces of the first one, but in another order, reversed, or reversed and mirrored,
///    gets those of the first one (and is mirrored back);
/// 2. vertices that lie on one another are made one, if they do in all meshes of one face list and the
///    defects do not grow by it;
/// 3. faces that name a vertex twice or repeat another go; faces are turned so that neighbours agree;
///    pieces are chosen; vertices without a face go;
/// 4. meshes that are mirror images of the others are mirrored back, and surfaces that are inside out
///    are reversed;
/// 5. meshes whose sizes differ from the others' by the ratio of two units are scaled to theirs, where it can be no
///    other two: of the logarithms, the difference of the means of both parts, of n and m members, is within
///    max(0.05, 3 s sqrt(1/n + 1/m)) of one ratio alone; s is their pooled standard deviation with one more
///    measurement of 0.1. Else `kept` says why they are not.
/// Meshes of one face list are treated alike, so that they stay in correspondence. What is left to
/// repair, find_defects() and collect() say.
/// @param meshes  Finite; faces name vertices that exist. Cost: about that of collect().
/// @throws LimitExceeded if a surface would be split into more than 1000 pieces.
[[nodiscard]] RepairedMeshes repair_meshes(std::vector<NamedMesh> meshes,
                                           const MeshRepairOptions& options = {});

} // namespace shape
