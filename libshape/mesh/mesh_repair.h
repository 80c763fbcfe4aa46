// SPDX-License-Identifier: MIT

#pragma once

#include <functional>
#include <string>
#include <vector>

#include "libshape/mesh/collection.h"

namespace shape {

/// What becomes of a surface in several pieces.
enum class Components
{
    KeepMain, ///< KeepLargest; all of them where the second has half of its faces, or a fifth of all: which is meant?
    KeepLargest, ///< That with the most faces, of equally many the one with the larger area.
    Split,       ///< Each piece becomes a mesh of its own, NAME_part1 and so on, in order of faces.
};

struct MeshRepairOptions
{
    Components components = Components::KeepMain; ///< A surface in several pieces is treated so.
    /// Names the meshes of a sound collection that are far from all others, by index, as find_outlying_meshes() does:
    /// they are neither mirrored nor scaled, as what they are is not known. None if it is empty.
    std::function<std::vector<std::size_t>(const Collection& meshes)> find_outliers = {};
};

/// Meshes made from others, and what was done.
struct RepairedMeshes
{
    std::vector<NamedMesh> meshes;
    std::vector<std::string> changes; ///< A sentence each, naming the meshes.
    std::vector<std::string> kept; ///< The same of what stays as it is, though it is odd, and why.
    bool asks_for_components = false; ///< KeepMain had no main piece to keep.
};

/// Repairs what can be repaired without a guess about the shape. In this order:
/// 1. a mesh with the faces of the first one, but in another order, reversed, or reversed and mirrored,
///    gets those of the first one (and is mirrored back);
/// 2. boundary vertices that lie on one another (seam_vertices()) are made one, if they do in all meshes of one face
///    list and the defects do not grow by it;
/// 3. faces that name a vertex twice or repeat another go; faces are turned so that neighbours agree;
///    pieces are chosen, but where others meet the largest one along its rim at two places and more, within what
///    seam_vertices() calls near, all are kept; vertices without a face go;
/// 4. meshes that are mirror images of the others are mirrored back, and surfaces that are inside out
///    are reversed; of open ones that is a guess where compare_handedness() finds them `bent`;
/// 5. meshes whose sizes differ from the others' by a factor of 10, 100 or 1000 are scaled to theirs, where that is
///    beyond doubt. With the difference d of the means of the logarithms of both parts, of n and m members, their pooled
///    standard deviation s, the same S with one more measurement of 0.1, and k = 3 sqrt(1/n + 1/m): d is within
///    max(0.05, k S) of one ratio of units alone (inches and feet are among them); and it is within 0.05 of log 10, where
///    k s <= 0.08 and k S <= 0.14, or within 0.25 of log 100 or log 1000.
///    By ten, one mesh is scaled beside six others at the least, and two beside three.
/// Outliers stay as they are in 4 and 5. What is not done, `kept` says, and why.
/// Meshes of one face list are treated alike, so that they stay in correspondence. What is left to
/// repair, find_defects() and collect() say.
/// @param meshes  Finite; faces name vertices that exist. Cost: about that of collect().
/// @throws LimitExceeded if a surface would be split into more than 1000 pieces.
[[nodiscard]] RepairedMeshes repair_meshes(std::vector<NamedMesh> meshes,
                                           const MeshRepairOptions& options = {});

} // namespace shape
