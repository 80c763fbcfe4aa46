// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "libshape/embedding/start/face_layout.h"
#include "libshape/embedding/start/face_patches.h"
#include "libshape/linalg/sparse_cholesky.h"

namespace shape::internal {

/// Orients the faces of a mesh from the transitions between neighbours, which need not agree around
/// loops.
///
/// In a patch of faces, frames spread along the spanning tree of the most trusted edges. Between
/// patches, they are the three smallest eigenvectors of the connection Laplacian of the patches,
///
///     min sum over edges e between patches p, q of w_e |G_p A_e - G_q|^2,   sum |G_p|^2 fixed,
///
/// w_e being the trust in e times that in the least trusted edges of the trees on both sides;
/// each G_p replaced by the nearest rotation. Unlike a least-squares solution with one frame held
/// fixed, eigenvectors do not fade away from that frame where loops do not close.
class PatchFrames
{
public:
    /// Cost: the analysis of a sparse matrix of size 3 #patches.
    explicit PatchFrames(std::shared_ptr<const FacePatches> patches);

    /// @param transitions  #E rotations from the frame left of an edge to that right of it (face_layout.h).
    /// @param weights  #E trust in a transition [1], in (0, 1].
    /// @param memory  Frames no longer needed, whose memory serves again.
    /// @return #F rotations from the frame of a face to one global frame.
    /// @throws InvalidInput if a size is wrong.
    /// Cost: O(#F), one sparse Cholesky factorisation of size 3 #patches. Works in memory that is
    /// kept: not safe to call concurrently.
    [[nodiscard]] Rotations face_frames(const Rotations& transitions,
                                        const Eigen::VectorXd& weights, Rotations memory = {});

private:
    void grow_trees(const Rotations& transitions, const Eigen::VectorXd& weights,
                    Rotations& frames);
    void connect(const Rotations& transitions, const Eigen::VectorXd& weights,
                 const Rotations& frames);

    std::shared_ptr<const FacePatches> patches_;
    Eigen::VectorXd
        trust_; // of the faces: the weight of the lightest edge on the way from the root
    SparseMatrix connection_; // the connection Laplacian
    SparseCholesky factor_;
};

} // namespace shape::internal
