// SPDX-License-Identifier: MIT

#include "libshape/embedding/sequence_jumps.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "libshape/base/order_statistics.h"
#include "libshape/base/require.h"
#include "libshape/mesh/alignment.h"
#include "libshape/mesh/dihedral_angles.h"

namespace shape {
using namespace internal;
namespace {

/// Sum of the areas of the faces at each edge, #E, times two.
Eigen::VectorXd areas_at_edges(const Topology& topology, const Points& points)
{
    Eigen::VectorXd areas = Eigen::VectorXd::Zero(topology.edge_count());
    for (int f = 0; f < topology.face_count(); ++f) {
        const Eigen::RowVector3d a = points.row(topology.faces()(f, 0));
        const Eigen::RowVector3d b = points.row(topology.faces()(f, 1));
        const Eigen::RowVector3d c = points.row(topology.faces()(f, 2));
        const double area = (b - a).cross(c - a).norm();
        for (const int edge : topology.face_edges().row(f))
            areas[edge] += area;
    }
    return areas;
}

/// Step k in units of an ordinary step nearby; 0 where too few are nearby.
double ratio_to_nearby(const std::vector<SequenceStep>& steps, std::size_t k,
                       double SequenceStep::*measure, std::size_t reach, double least)
{
    std::vector<double> nearby;
    for (std::size_t j = k - std::min(k, reach); j < std::min(steps.size(), k + reach + 1); ++j)
        if (j != k)
            nearby.push_back(steps[j].*measure);
    if (nearby.size() < 2)
        return 0.0;
    return steps[k].*measure / std::max(median(std::move(nearby)), least);
}

} // namespace

SequenceStep measure_step(const Topology& topology, const Points& before, const Points& after)
{
    const Eigen::VectorXd before_angles = dihedral_angles(topology, before);
    const Eigen::VectorXd after_angles = dihedral_angles(topology, after);
    const Eigen::VectorXd weights = areas_at_edges(topology, before);
    double bending = 0.0;
    for (int e = 0; e < topology.edge_count(); ++e) {
        const double change = wrapped_angle(after_angles[e] - before_angles[e]);
        bending += weights[e] * change * change;
    }
    const Points moved = best_rigid_motion(after, before)(after);
    const double diagonal = bounding_box_diagonal(before);
    const double weight = weights.sum();
    return {.displacement =
                diagonal > 0.0 ? (moved - before).rowwise().norm().maxCoeff() / diagonal : 0.0,
            .bending = weight > 0.0 ? std::sqrt(bending / weight) : 0.0};
}

void check(const JumpOptions& options)
{
    require_positive(options.ratio, "JumpOptions.ratio");
    require(options.reach > 0, "JumpOptions.reach", options.reach, "> 0");
    require_positive(options.least_displacement, "JumpOptions.least_displacement");
    require_positive(options.least_bending, "JumpOptions.least_bending");
}

std::vector<SequenceJump> find_jumps(const std::vector<SequenceStep>& steps,
                                     const JumpOptions& options)
{
    check(options);
    std::vector<SequenceJump> jumps;
    for (std::size_t k = 0; k < steps.size(); ++k) {
        const double ratio = std::max(ratio_to_nearby(steps, k, &SequenceStep::displacement,
                                                      options.reach, options.least_displacement),
                                      ratio_to_nearby(steps, k, &SequenceStep::bending,
                                                      options.reach, options.least_bending));
        if (ratio > options.ratio)
            jumps.push_back({k, ratio});
    }
    return jumps;
}

} // namespace shape
