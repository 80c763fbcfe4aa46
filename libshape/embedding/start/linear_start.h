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
/// lengths and angles (face_layout.h), oriented patch by patch with transitions trusted by how well
/// the walks around their ends close (patch_frames.h), and positions solved for; then face steps,
/// each rotating every face to its best fit (face_fit.h) and solving again.
class LinearStart
{
public:
    /// All must outlive the object.
    /// @param solve  What laplacian.single_precision() gave.
    LinearStart(const Topology& topology, std::shared_ptr<const FacePatches> patches,
                const EdgeLaplacian& laplacian, const SinglePrecisionSolve& solve);

    /// @param target  #E lengths, > 0, and dihedral angles.
    /// @param face_steps  >= 0; one more back-substitution is done.
    /// @return Valid until the next call.
    /// Cost: O(#F) and the back-substitutions. Works in memory that is kept: not safe to call
    /// concurrently.
    [[nodiscard]] const Points& points(const ShapePoint& target, int face_steps);

private:
    void solve_for_points();

    const Topology& topology_;
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
