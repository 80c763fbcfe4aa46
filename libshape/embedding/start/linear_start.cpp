// SPDX-License-Identifier: MIT

#include "libshape/embedding/start/linear_start.h"

#include <algorithm>
#include <utility>

#include "libshape/base/threads.h"
#include "libshape/base/to_size.h"
#include "libshape/embedding/start/face_fit.h"

namespace shape::internal {
namespace {

using Eigen::VectorXd;

/// Trust in the transition across every edge: 1 / (1 + (r_u^2 + r_v^2) / 0.1^2) with the closure
/// angles r [rad] at its ends. A few wild loops (slivers, folds) must not turn all frames. At 0.1 rad,
/// 6 degrees, half of it is gone; on average at most 0.023 is, in the pairs of docs/experiments/embedding.md.
void set_transition_weights(const Topology& topology, const Rotations& transitions,
                            VectorXd& weights)
{
    constexpr double scale = 0.1;
    const VectorXd angles = closure_angles(topology, transitions);
    weights.resize(topology.edge_count());
    parallel_for(to_size(topology.edge_count()), 8192, [&](std::size_t begin, std::size_t end) {
        for (int e = static_cast<int>(begin); e < static_cast<int>(end); ++e) {
            const double u = angles[topology.edges()(e, 0)];
            const double v = angles[topology.edges()(e, 1)];
            weights[e] = 1.0 / (1.0 + (u * u + v * v) / (scale * scale));
        }
    });
}

} // namespace

LinearStart::LinearStart(const Topology& topology, std::shared_ptr<const FacePatches> patches,
                         const ReferencePatches& reference, const EdgeLaplacian& laplacian,
                         const SinglePrecisionSolve& solve)
    : topology_(topology),
      reference_(reference),
      laplacian_(laplacian),
      single_precision_(solve),
      patch_frames_(std::move(patches))
{
}

const Points& LinearStart::points(const ShapePoint& target, int face_steps,
                                  std::optional<double> turn_share)
{
    layout_ =
        lay_out_faces(topology_, target.edge_lengths, target.dihedral_angles, std::move(layout_));
    set_transition_weights(topology_, layout_.transitions, trust_);
    // Where every walk closes (r < 3e-6) there may be a mesh with all lengths and angles as wanted, and
    // single precision would lose it.
    closes_ = trust_.minCoeff() > 1.0 - 1e-9;
    orient(target, turn_share);
    solve_for_points();
    for (int step = 0; step < face_steps; ++step) {
        frames_ = fit_faces(topology_, layout_, laplacian_.weights(), points_, std::move(frames_));
        solve_for_points();
    }
    return points_;
}

void LinearStart::orient(const ShapePoint& target, std::optional<double> turn_share)
{
    // Above the distrust of helices (6e-5), whose transitions are right to the last edge, and below that
    // of scanned and modelled shapes (9e-4 to 0.023; docs/experiments/embedding.md).
    constexpr double agreement = 3e-4;
    const double distrust = 1.0 - trust_.mean();
    if (target.patch_turns.size() == 0)
        share_ = 0.0;
    else if (turn_share)
        share_ = *turn_share;
    else
        share_ = distrust > agreement ? 1.0 - agreement / distrust * (agreement / distrust) : 0.0;
    if (share_ == 0.0) {
        frames_ = patch_frames_.face_frames(layout_.transitions, trust_, std::move(frames_));
        return;
    }
    if (!turned_frames_)
        turned_frames_.emplace(std::shared_ptr<const FacePatches>(
            std::shared_ptr<void>(), &reference_.patches)); // not owned
    const PatchTurning turning{reference_, target.patch_turns, share_};
    frames_ =
        turned_frames_->face_frames(layout_.transitions, trust_, std::move(frames_), &turning);
}

void LinearStart::solve_for_points()
{
    if (closes_)
        points_ = laplacian_.positions(layout_, frames_);
    else
        laplacian_.positions(layout_, frames_, single_precision_, memory_, points_);
}

} // namespace shape::internal
