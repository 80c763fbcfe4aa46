// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "libshape/edge_space/patch_turns.h"
#include "libshape/embedding/start/face_layout.h"
#include "libshape/linalg/sparse_cholesky.h"
#include "libshape/mesh/face_patches.h"

namespace shape::internal {

/// What is known of how patches turn against each other, beside transitions.
struct PatchTurning
{
    const ReferencePatches& reference; ///< Of the same patches.
    const Eigen::VectorXd& turns;      ///< As PatchTurns has them [rad].
    double share;                      ///< Of turns against transitions, in [0, 1].
};

/// Orients the faces of a mesh from the transitions between neighbours, which need not agree around
/// loops.
///
/// In a patch of faces, frames spread along the spanning tree of the most trusted edges. Between
/// patches, they are the three smallest eigenvectors of the connection Laplacian of the patches,
///
///     min sum over edges e between patches p, q of w_e |G_p A_e - G_q|^2,   sum |G_p|^2 fixed,
///
/// w_e being the trust in e times that in the least trusted edges of the trees on both sides;
/// each G_p replaced by the nearest rotation. With turns t_pq, every w_e is multiplied by 1 - c_pq, and
/// for the pairs of patches the terms
///
///     c_pq b_pq |G_p Q_p exp(t_pq) Q_q^T - G_q|^2,   c_pq = share max(0.01, (1 + cos |t_pq|) / 2),
///
/// are added, Q_p taking the reference to patch p as its tree lays it out, b_pq being the number of
/// edges between the two. Unlike a least-squares solution with one frame held fixed, eigenvectors do not
/// fade away from that frame where loops do not close.
class PatchFrames
{
public:
    /// Cost: the analysis of a sparse matrix of size 3 #patches.
    explicit PatchFrames(std::shared_ptr<const FacePatches> patches);

    /// @param transitions  #E rotations from the frame left of an edge to that right of it (face_layout.h).
    /// @param weights  #E trust in a transition [1], in (0, 1].
    /// @param memory  Frames no longer needed, whose memory serves again.
    /// @param turning  Turns between the patches, if they are known.
    /// @return #F rotations from the frame of a face to one global frame.
    /// @throws InvalidInput if a size is wrong.
    /// Cost: O(#F), one sparse Cholesky factorisation of size 3 #patches. Works in memory that is
    /// kept: not safe to call concurrently.
    [[nodiscard]] Rotations face_frames(const Rotations& transitions,
                                        const Eigen::VectorXd& weights, Rotations memory = {},
                                        const PatchTurning* turning = nullptr);

private:
    void grow_trees(const Rotations& transitions, const Eigen::VectorXd& weights,
                    Rotations& frames);
    void connect(const Rotations& transitions, const Eigen::VectorXd& weights,
                 const Rotations& frames, const PatchTurning* turning);
    void set_block(const FacePatches::Pair& pair, const Eigen::Matrix3d& block);
    void factorise(const std::vector<double>& pair_weights);

    std::shared_ptr<const FacePatches> patches_;
    Eigen::VectorXd
        trust_; // of the faces: the weight of the lightest edge on the way from the root
    SparseMatrix connection_; // the connection Laplacian
    SparseCholesky factor_;
};

} // namespace shape::internal
