// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <vector>

#include "libshape/linalg/dense.h"
#include "libshape/mesh/face_patches.h"
#include "libshape/mesh/points.h"
#include "libshape/mesh/renumbering.h"
#include "libshape/mesh/rotations.h"
#include "libshape/mesh/topology.h"

// The companion of orientation: how a mesh lies in the large. Dihedral angles bend every edge by
// itself, and what they do not agree on adds up along the surface. So the rotations of whole patches
// go along: those of a patch against its neighbours, which need no common orientation.

namespace shape::internal {

/// Patches of a reference mesh, and how other meshes are fitted to them.
struct ReferencePatches
{
    FacePatches patches;   ///< Of about 32 faces.
    Rotations frames;      ///< Of the faces of the reference, face_frames().
    Eigen::VectorXd areas; ///< Of its faces [length^2].

    ReferencePatches(const Topology& topology, const Points& reference);

    /// The rotation of a patch that takes the frames of the reference nearest to others, weighted by
    /// areas: maximises sum_f A_f trace(F_f^T Q R_f).
    /// @param others  F: #F.
    [[nodiscard]] Eigen::Quaterniond rotation(int patch, const Rotations& others) const;

    /// How the patches of a mesh of this topology turn from one to the next: see PatchTurns.
    [[nodiscard]] Eigen::VectorXd turns(const Topology& topology, const Points& mesh) const;
};

/// Turns from patch to patch, between a reference and other meshes of one topology.
///
/// Q_p rotates patch p of the reference nearest to that of a mesh. Its turns are the rotation vectors
/// of Q_p^T Q_q for all pairs p, q of neighbouring patches [rad], three numbers a pair in the order of
/// FacePatches::pairs: no rigid motion of the mesh changes them, those of the reference are 0, and
/// they are blended as dihedral angles are. Rotations that grow from patch to patch, as those of a
/// helix, may add up to any number of turns. Neighbours that turn by nearly half a turn against each
/// other say little; the embedding trusts them accordingly.
///
/// There are about 0.28 #F numbers, a tenth of the lengths and angles; none for a mesh that is one
/// patch.
class PatchTurns
{
public:
    PatchTurns(const Topology& topology, const Points& reference);

    [[nodiscard]] Eigen::Index size() const; ///< 3 #pairs.

    /// The turns of a mesh, size() [rad].
    /// @throws InvalidInput if it has another number of vertices.
    /// Cost: O(#F).
    [[nodiscard]] Eigen::VectorXd of(const Points& mesh) const;

    /// The same of several, one a row.
    [[nodiscard]] RowMatrix of(const std::vector<Points>& meshes) const;

private:
    Renumbering renumbering_;
    ReferencePatches reference_; // in that order, as the embedding has it
};

} // namespace shape::internal
