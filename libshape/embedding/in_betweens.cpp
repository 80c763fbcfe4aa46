// SPDX-License-Identifier: MIT

#include "libshape/embedding/in_betweens.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <utility>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/to_size.h"
#include "libshape/edge_space/paths.h"
#include "libshape/embedding/finished_embedding.h"
#include "libshape/mesh/alignment.h"
#include "libshape/mesh/dihedral_angles.h"
#include "libshape/mesh/edge_lengths.h"

namespace shape {
using namespace internal;
namespace {

void check(const Topology& topology, const std::vector<Keyframe>& keyframes)
{
    if (keyframes.size() < 2)
        throw InvalidInput(join("a sequence needs at least 2 keyframes, not ", keyframes.size()));
    for (std::size_t i = 0; i < keyframes.size(); ++i) {
        const Keyframe& key = keyframes[i];
        if (key.points.rows() != topology.vertex_count() ||
            key.target.edge_lengths.size() != topology.edge_count() ||
            key.target.dihedral_angles.size() != topology.edge_count())
            throw InvalidInput(join("keyframe ", i, " does not fit the topology"));
        if (i > 0 && !(key.time > keyframes[i - 1].time))
            throw InvalidInput(join("keyframe ", i, " is at time ", key.time,
                                    ", must be after the one before, ", keyframes[i - 1].time));
    }
}

ShapePoint difference(const Topology& topology, const Keyframe& key)
{
    return {edge_lengths(topology, key.points) - key.target.edge_lengths,
            (dihedral_angles(topology, key.points) - key.target.dihedral_angles)
                .unaryExpr(&wrapped_angle)};
}

ShapePoint sum(const ShapePoint& a, double factor, const ShapePoint& b)
{
    return {a.edge_lengths + factor * b.edge_lengths,
            a.dihedral_angles + factor * b.dihedral_angles};
}

/// 0 to 1 with level ends.
double eased(double share)
{
    return share * share * (3.0 - 2.0 * share);
}

/// Points whose centroid is 0, between their best fits to two meshes.
Points place_between(const Points& points, const Points& before, const Points& after, double share)
{
    const RigidMotion a = best_rigid_motion(points, before);
    const RigidMotion b = best_rigid_motion(points, after);
    const Eigen::Quaterniond turn =
        Eigen::Quaterniond(a.rotation).slerp(share, Eigen::Quaterniond(b.rotation));
    return RigidMotion{turn.normalized().toRotationMatrix(),
                       a.translation + share * (b.translation - a.translation)}(points);
}

} // namespace

InBetweens::InBetweens(const Topology& topology, std::vector<Keyframe> keyframes,
                       std::vector<Points> references, const EmbeddingOptions& filler)
    : topology_(topology), keyframes_(std::move(keyframes))
{
    check(topology_, keyframes_);
    for (const Keyframe& key : keyframes_)
        differences_.push_back(difference(topology_, key));
    filler_.emplace(topology_, std::move(references), filler);
}

InBetweens::InBetweens(const Topology& topology, std::vector<Keyframe> keyframes,
                       KeyframeMotion motion)
    : topology_(topology), keyframes_(std::move(keyframes)), motion_(motion)
{
    check(topology_, keyframes_);
}

Embedding InBetweens::embed(double time, const ShapePoint& target) const
{
    const Clock::time_point start = Clock::now();
    const auto found = std::find_if(keyframes_.begin(), keyframes_.end(),
                                    [&](const Keyframe& key) { return key.time >= time; });
    if (found == keyframes_.end() || !(time >= keyframes_.front().time))
        throw InvalidInput(join("time ", time, " is outside that of the keyframes, [",
                                keyframes_.front().time, ", ", keyframes_.back().time, "]"));
    const auto after = to_size(found - keyframes_.begin());
    Embedding result;
    if (found->time == time)
        result.points = found->points;
    else if (filler_)
        result = fill(after - 1, time, target);
    else
        result.points = move(after - 1, time);
    const EmbeddingReport solver =
        std::exchange(result.report, measure_embedding(topology_, result.points, target));
    result.report.closure_energy = solver.closure_energy;
    result.report.iterations = solver.iterations;
    result.report.converged = solver.converged || !filler_;
    result.report.self_intersections = solver.self_intersections;
    result.report.new_self_intersections = solver.new_self_intersections;
    result.report.avoidable_self_intersections = solver.avoidable_self_intersections;
    result.report.setup_seconds = solver.setup_seconds;
    result.report.seconds = seconds_since(start);
    return result;
}

Embedding InBetweens::fill(std::size_t before, double time, const ShapePoint& target) const
{
    const Keyframe& a = keyframes_[before];
    const Keyframe& b = keyframes_[before + 1];
    const double share = eased((time - a.time) / (b.time - a.time));
    const ShapePoint shifted =
        sum(sum(target, 1.0 - share, differences_[before]), share, differences_[before + 1]);
    Embedding result = filler_->embed(shifted);
    result.points = place_between(result.points, a.points, b.points, share);
    return result;
}

Points InBetweens::move(std::size_t before, double time) const
{
    const auto count = static_cast<Eigen::Index>(keyframes_.size());
    Eigen::VectorXd times(count);
    for (Eigen::Index i = 0; i < count; ++i)
        times[i] = keyframes_[to_size(i)].time;
    const auto first = static_cast<Eigen::Index>(before);
    const Eigen::VectorXd weights =
        motion_ == KeyframeMotion::Spline
            ? catmull_rom_weights(times, time)
            : catmull_rom_weights(times.segment(first, 2), time); // two knots: the line
    const std::size_t offset = motion_ == KeyframeMotion::Spline ? 0 : before;
    Points points = Points::Zero(topology_.vertex_count(), 3);
    for (Eigen::Index i = 0; i < weights.size(); ++i)
        if (weights[i] != 0.0)
            points += weights[i] * keyframes_[offset + to_size(i)].points;
    return points;
}

} // namespace shape
