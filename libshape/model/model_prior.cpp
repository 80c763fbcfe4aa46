// SPDX-License-Identifier: MIT

#include "libshape/model/model_prior.h"

#include <cmath>
#include <variant>

#include "libshape/mesh/dihedral_angles.h"
#include "libshape/mesh/edge_lengths.h"

namespace shape {
using Eigen::VectorXd;

namespace {

ShapePoint point_at(const ShapeModel& model, const VectorXd& scores)
{
    const DecodedShape shape = model_point(model, scores, model.mean_size());
    if (const auto* point = std::get_if<ShapePoint>(&shape))
        return *point;
    const Points& points = std::get<Points>(shape);
    return {edge_lengths(model.topology, points), dihedral_angles(model.topology, points)};
}

} // namespace

ShapePrior prior_of(const ShapeModel& model)
{
    const int modes = model.mode_count();
    ShapePrior prior;
    prior.mean = point_at(model, VectorXd::Zero(modes));
    prior.length_steps.resize(modes, model.topology.edge_count());
    prior.angle_steps.resize(modes, model.topology.edge_count());
    for (int k = 0; k < modes; ++k) {
        const VectorXd step = std::sqrt(model.variances[k]) * VectorXd::Unit(modes, k);
        const ShapePoint up = point_at(model, step), down = point_at(model, -step);
        prior.length_steps.row(k) = 0.5 * (up.edge_lengths - down.edge_lengths);
        for (int e = 0; e < model.topology.edge_count(); ++e)
            prior.angle_steps(k, e) =
                0.5 * wrapped_angle(up.dihedral_angles[e] - down.dihedral_angles[e]);
    }
    // Fits err too, and alike along the surface: no model must be trusted to explain all of a fit.
    constexpr double noise_share = 3e-3;
    prior.noise = noise_share * prior.length_steps.squaredNorm();
    return prior;
}

} // namespace shape
