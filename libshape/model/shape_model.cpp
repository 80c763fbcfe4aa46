// SPDX-License-Identifier: MIT

#include "libshape/model/shape_model.h"

#include <cmath>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/edge_space/admissibility.h"
#include "libshape/statistics/mean.h"
#include "libshape/statistics/principal_components.h"
#include "libshape/statistics/projection.h"

namespace shape {

ShapeModel fit_model(const Collection& collection, const ModelOptions& options)
{
    const ShapeVectors vectors = encode(collection, options.scale);
    PrincipalComponents components = principal_components(
        vectors.edge_lengths, {.modes = options.modes, .variance = options.variance});
    return {.topology = collection.topology,
            .reference_points = collection.points.front(),
            .scale = options.scale,
            .mean_edge_lengths = std::move(components.mean),
            .mean_dihedral_angles = mean_of_rows(vectors.dihedral_angles),
            .mode_edge_lengths = std::move(components.modes),
            .mode_dihedral_angles = companion_modes(components, vectors.dihedral_angles),
            .variances = std::move(components.variances),
            .total_variance = components.total_variance,
            .scores = std::move(components.scores),
            .sizes = vectors.sizes,
            .names = collection.names,
            .labels = collection.labels};
}

ShapePoint model_point(const ShapeModel& model, const Eigen::VectorXd& scores, double size)
{
    const Eigen::Index count = scores.size();
    if (count > model.mode_count())
        throw InvalidInput(
            join("model point: ", count, " scores, the model has ", model.mode_count(), " modes"));
    for (Eigen::Index k = 0; k < count; ++k)
        if (!std::isfinite(scores[k]))
            throw InvalidInput(
                join("model point: score ", k, " is ", scores[k], ", must be finite"));
    if (model.scale == Scale::Unit && !(size > 0.0 && std::isfinite(size)))
        throw InvalidInput(join("model point: size is ", size, ", must be > 0 and finite"));
    const double factor = model.scale == Scale::Unit ? size : 1.0;
    return {factor * (model.mean_edge_lengths +
                      model.mode_edge_lengths.topRows(count).transpose() * scores),
            model.mean_dihedral_angles +
                model.mode_dihedral_angles.topRows(count).transpose() * scores};
}

Projection project(const ShapeModel& model, const Collection& collection)
{
    if (!(collection.topology == model.topology))
        throw InvalidInput(join(
            "projection: the meshes (", collection.topology.vertex_count(), " vertices, ",
            collection.topology.face_count(), " faces) have another triangulation than the model (",
            model.topology.vertex_count(), " vertices, ", model.topology.face_count(), " faces)"));
    ShapeVectors vectors = encode(collection, model.scale);
    SubspaceProjection projection = project_onto_subspace(
        vectors.edge_lengths, model.mean_edge_lengths, model.mode_edge_lengths);
    return {.names = collection.names,
            .labels = collection.labels,
            .scores = std::move(projection.scores),
            .sizes = std::move(vectors.sizes),
            .residuals = std::move(projection.residuals)};
}

FeasibleRange feasible_range(const ShapeModel& model, int mode, double limit)
{
    if (mode < 0 || mode >= model.mode_count())
        throw InvalidInput(
            join("feasible range: mode is ", mode, ", must be in [0, ", model.mode_count(), ")"));
    if (!(limit > 0.0))
        throw InvalidInput(join("feasible range: limit is ", limit, ", must be > 0"));
    const Eigen::VectorXd deviation =
        std::sqrt(model.variances[mode]) * model.mode_edge_lengths.row(mode).transpose();
    const auto reach = [&](const Eigen::VectorXd& direction) {
        return feasible_step(model.topology, model.mean_edge_lengths, direction, limit);
    };
    return {.low = -reach(-deviation), .high = reach(deviation)};
}

} // namespace shape
