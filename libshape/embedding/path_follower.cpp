// SPDX-License-Identifier: MIT

#include "libshape/embedding/path_follower.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/mesh/dihedral_angles.h"
#include "libshape/mesh/edge_lengths.h"

namespace shape {

using Eigen::VectorXd;

namespace {

/// Angles that lie the share t of the shorter way from a to b.
VectorXd blend_angles(const VectorXd& a, const VectorXd& b, double t)
{
    return a + t * (b - a).unaryExpr([](double angle) { return wrapped_angle(angle); });
}

} // namespace

PathFollower::PathFollower(const Topology& topology, const Points& start,
                           std::function<VectorXd(double s)> lengths, VectorXd end_angles,
                           const PathFollowerOptions& options)
    : topology_(topology),
      lengths_(std::move(lengths)),
      end_angles_(std::move(end_angles)),
      options_(options),
      start_{start, dihedral_angles(topology, start)}
{
    if (end_angles_.size() != topology.edge_count())
        throw InvalidInput(join("end_angles has ", end_angles_.size(), " values, the topology ",
                                topology.edge_count(), " edges"));
    if (options.steps < 1)
        throw InvalidInput(join("steps is ", options.steps, ", must be >= 1"));
    if (options.rounds < 1)
        throw InvalidInput(join("rounds is ", options.rounds, ", must be >= 1"));
    here_ = start_;
    next_ = next_stop();
}

/// The mesh at the target; where lengths are not met, wanted again with the angles it got.
ContinuedMesh PathFollower::reach(const Points& from, ShapePoint target) const
{
    ContinuedMesh mesh{from, 0.0, 0, false};
    for (int round = 0; round < options_.rounds; ++round) {
        const int iterations = mesh.iterations;
        mesh = continue_to(topology_, mesh.points, target, options_.continuation);
        mesh.iterations += iterations;
        const VectorXd lengths = edge_lengths(topology_, mesh.points);
        const double worst = (lengths.array() / target.edge_lengths.array() - 1.0).abs().maxCoeff();
        if (worst <= options_.edge_tolerance)
            break;
        target.dihedral_angles = dihedral_angles(topology_, mesh.points);
    }
    return mesh;
}

PathFollower::Stop PathFollower::next_stop() const
{
    const double left = options_.steps - step_;
    const ShapePoint target{lengths_((step_ + 1.0) / options_.steps),
                            blend_angles(here_.angles, end_angles_, 1.0 / left)};
    const ContinuedMesh mesh = reach(here_.points, target);
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
    ContinuedMesh mesh = reach(share < 0.5 ? here_.points : next_.points, target);
    return {std::move(target), std::move(mesh)};
}

} // namespace shape
