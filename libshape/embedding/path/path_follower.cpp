// SPDX-License-Identifier: MIT

#include "libshape/embedding/path/path_follower.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/require.h"
#include "libshape/mesh/dihedral_angles.h"
#include "libshape/mesh/edge_lengths.h"

namespace shape {
using namespace internal;

using Eigen::VectorXd;

namespace {

/// Angles that lie the share t of the shorter way from a to b.
VectorXd blend_angles(const VectorXd& a, const VectorXd& b, double t)
{
    return a + t * (b - a).unaryExpr([](double angle) { return wrapped_angle(angle); });
}

} // namespace

void check(const PathFollowerOptions& options)
{
    require_at_least(1, options.steps, "PathFollowerOptions.steps");
    require_positive(options.angle_gain, "PathFollowerOptions.angle_gain");
    require_positive(options.guidance, "PathFollowerOptions.guidance");
    require_positive(options.smoothness, "PathFollowerOptions.smoothness");
    require_positive(options.stiffness, "PathFollowerOptions.stiffness");
    require_at_least(0, options.rounds, "PathFollowerOptions.rounds");
    require_not_negative(options.edge_tolerance, "PathFollowerOptions.edge_tolerance");
}

PathFollower::PathFollower(const Topology& topology, const Points& start,
                           std::function<VectorXd(double s)> lengths, VectorXd end_angles,
                           const PathFollowerOptions& options)
    : topology_(topology),
      lengths_(std::move(lengths)),
      end_angles_(std::move(end_angles)),
      options_(options),
      continuation_(topology, lengths_(0.0).cwiseMin(lengths_(1.0))), // as fine as both ends
      start_{start, dihedral_angles(topology, start)}
{
    if (end_angles_.size() != topology.edge_count())
        throw InvalidInput(join("end_angles has ", end_angles_.size(), " values, the topology ",
                                topology.edge_count(), " edges"));
    check(options);
    here_ = start_;
    next_ = next_stop();
}

ContinuedMesh PathFollower::settle(const ContinuedMesh& mesh, const VectorXd& lengths)
{
    ContinuedMesh settled = continuation_.settle(mesh.points, lengths,
                                                 {.smoothness = options_.smoothness,
                                                  .stiffness = options_.stiffness,
                                                  .edge_tolerance = options_.edge_tolerance,
                                                  .rounds = options_.rounds});
    settled.iterations += mesh.iterations;
    return settled;
}

PathFollower::Stop PathFollower::next_stop()
{
    const bool is_last = step_ == options_.steps - 1;
    const double share = std::min(1.0, options_.angle_gain / (options_.steps - step_));
    const ShapePoint target{lengths_((step_ + 1.0) / options_.steps),
                            blend_angles(here_.angles, end_angles_, share)};
    // On the way, one Gauss-Newton step is guidance enough: what more of them gain, settling undoes. At the
    // end lengths and angles fit each other, and the mesh that has both is found.
    ContinuationOptions guided{.smoothness = options_.guidance};
    if (!is_last)
        guided.max_iterations = 1;
    const ContinuedMesh mesh =
        settle(continuation_.move(here_.points, target, guided), target.edge_lengths);
    return {mesh.points, dihedral_angles(topology_, mesh.points)};
}

PathMesh PathFollower::at(double s)
{
    if (!(s >= 0.0 && s <= 1.0))
        throw InvalidInput(join("s is ", s, ", must be in [0, 1]"));
    if (s == 0.0)
        return {{lengths_(0.0), start_.angles}, {start_.points, 0.0, 0, true}};
    const int wanted = std::min(static_cast<int>(s * options_.steps), options_.steps - 1);
    if (wanted < step_) {
        step_ = 0;
        here_ = start_;
        next_ = next_stop();
    }
    for (; step_ < wanted;) {
        here_ = std::move(next_);
        ++step_;
        next_ = next_stop();
    }
    const double share = s * options_.steps - step_;
    ShapePoint target{lengths_(s), blend_angles(here_.angles, next_.angles, share)};
    ContinuedMesh mesh = settle(
        continuation_.move(share < 0.5 ? here_.points : next_.points, target,
                           {.smoothness = options_.smoothness, .stiffness = options_.stiffness}),
        target.edge_lengths);
    return {std::move(target), std::move(mesh)};
}

} // namespace shape
