// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <vector>

#include "libshape/mesh/topology.h"

namespace shape {

/// Orients the faces of a mesh from the transitions between neighbours, which need not agree around
/// loops.
///
/// The faces are cut into connected patches of about 64. In a patch, frames spread along the
/// spanning tree of the most trusted edges. Between patches, they are the three smallest eigenvectors
/// of the connection Laplacian of the patches,
///
///     min sum over edges e between patches p, q of w_e |G_p A_e - G_q|^2,   sum |G_p|^2 fixed,
///
/// w_e being the trust in e times that in the least trusted edges of the trees on both sides;
/// each G_p replaced by the nearest rotation. Unlike a least-squares solution with one frame held
/// fixed, eigenvectors do not fade away from that frame where loops do not close.
class PatchFrames
{
public:
    explicit PatchFrames(const Topology& topology, int faces_per_patch = 64);

    /// @param transitions  #E rotations from the frame left of an edge to that right of it (face_layout.h).
    /// @param weights  #E trust in a transition [1], in (0, 1].
    /// @return #F rotations from the frame of a face to one global frame.
    /// @throws InvalidInput if a size is wrong.
    /// Cost: O(#F log), one sparse Cholesky factorisation of size 3 #patches.
    [[nodiscard]] std::vector<Eigen::Matrix3d> face_frames(
        const std::vector<Eigen::Matrix3d>& transitions, const Eigen::VectorXd& weights) const;

    [[nodiscard]] int patch_count() const { return static_cast<int>(patches_.size()); }

private:
    Topology topology_;
    std::vector<int> patch_of_face_;
    std::vector<std::vector<int>> patches_; // faces, the first is the root
    std::vector<int> bridges_;              // edges between patches
};

} // namespace shape
