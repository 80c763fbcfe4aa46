// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <memory>

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
/// Patches turn against each other as the target's turns say, or where it has none as transitions do,
/// trusted by how well the walks around their ends close.
class LinearStart
{
public:
    /// All must outlive the object.
    /// @param reference  Of the turns of the targets; null: they have none.
    /// @param solve  What laplacian.single_precision() gave.
    LinearStart(const Topology& topology, const ReferencePatches* reference,
                const EdgeLaplacian& laplacian, const SinglePrecisionSolve& solve);

    /// @param target  #E lengths, > 0, and dihedral angles; and turns if there is a reference.
    /// @param face_steps  >= 0; one more back-substitution is done.
    /// @return Valid until the next call.
    /// Cost: O(#F) and the back-substitutions. Works in memory that is kept: not safe to call
    /// concurrently.
    [[nodiscard]] const Points& points(const ShapePoint& target, int face_steps);

    /// How much of the last frames is due to turns, m^2 / (m^2 + 3e-4^2), m being the mean distrust in
    /// transitions: where these agree with each other they are right, however far they wind.
    [[nodiscard]] double turn_share() const;

private:
    void solve_for_points();

    const Topology& topology_;
    const ReferencePatches* reference_;
    const EdgeLaplacian& laplacian_;
    const SinglePrecisionSolve& single_precision_;
    PatchFrames patch_frames_;

    FaceLayout layout_;
    Eigen::VectorXd trust_; // in transitions
    bool closes_ = false;   // every walk around a vertex does
    Rotations frames_;
    EdgeLaplacian::Memory memory_;
    Points points_;
};

} // namespace shape::internal
