// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>

#include "libshape/edge_space/shape_vectors.h"
#include "libshape/embedding/start/edge_laplacian.h"
#include "libshape/embedding/start/face_layout.h"
#include "libshape/embedding/start/patch_frames.h"
#include "libshape/linalg/single_precision_solve.h"
#include "libshape/mesh/points.h"
#include "libshape/mesh/topology.h"

namespace shape::internal {

/// A mesh near wanted lengths and dihedral angles by Laplace solves alone: every face laid out by
/// lengths and angles (face_layout.h), oriented patch by patch (patch_frames.h), and positions solved
/// for; then face steps, each rotating every face to its best fit (face_fit.h) and solving again.
/// Patches turn against each other as transitions do, trusted by how well the walks around their ends
/// close; and where these do not agree, as the turns of the target say, if it has any.
class LinearStart
{
public:
    /// All must outlive the object.
    /// @param patches  For transitions alone.
    /// @param reference  Of the turns of targets.
    /// @param solve  What laplacian.single_precision() gave.
    LinearStart(const Topology& topology, std::shared_ptr<const FacePatches> patches,
                const ReferencePatches& reference, const EdgeLaplacian& laplacian,
                const SinglePrecisionSolve& solve);

    /// @param target  #E lengths, > 0, and dihedral angles; and turns, or none.
    /// @param face_steps  >= 0; one more back-substitution is done.
    /// @param turn_share  In place of turn_share(), if given: in [0, 1).
    /// @return Valid until the next call.
    /// @throws InvalidInput if there are turns, and not 3 for each pair of patches.
    /// Cost: O(#F) and the back-substitutions. Works in memory that is kept: not safe to call
    /// concurrently.
    [[nodiscard]] const Points& points(const ShapePoint& target, int face_steps,
                                       std::optional<double> turn_share = {});

    /// How much turns had a say in the last points, in [0, 1): max(0, 1 - (3e-4 / m)^2), m being the mean
    /// distrust in transitions. Where these agree with each other they are right, however far they
    /// wind. 0 without turns.
    [[nodiscard]] double turn_share() const { return share_; }

private:
    void orient(const ShapePoint& target, std::optional<double> turn_share);
    void solve_for_points();

    const Topology& topology_;
    const ReferencePatches& reference_;
    const EdgeLaplacian& laplacian_;
    const SinglePrecisionSolve& single_precision_;
    PatchFrames patch_frames_;
    std::optional<PatchFrames> turned_frames_; // once there is need

    FaceLayout layout_;
    Eigen::VectorXd trust_; // in transitions
    bool closes_ = false;   // every walk around a vertex does
    double share_ = 0.0;    // of turns
    Rotations frames_;
    EdgeLaplacian::Memory memory_;
    Points points_;
};

} // namespace shape::internal
