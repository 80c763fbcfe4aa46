// SPDX-License-Identifier: MIT

#include "libshape/model/shape_model.h"

#include <cmath>
#include <utility>

#include "libshape/base/counted.h"
#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/require.h"
#include "libshape/linalg/added_rows.h"
#include "libshape/model/model_frame.h"
#include "libshape/statistics/mean.h"
#include "libshape/statistics/principal_components.h"
#include "libshape/statistics/projection.h"

namespace shape {
using namespace internal;

void check(const ModelOptions& options)
{
    require_at_least(0, options.modes, "ModelOptions.modes");
    require(options.variance > 0.0 && options.variance <= 1.0, "ModelOptions.variance",
            options.variance, "in (0, 1]");
    require(options.modes == 0 || options.variance == 1.0, "ModelOptions.variance",
            options.variance, "1 where modes, too, says how many are kept");
    check(options.space);
}

ShapeModel fit_model(const Collection& collection, const ModelOptions& options)
{
    check(options);
    if (collection.size() < 2)
        throw InvalidInput("a model needs at least 2 meshes, there is 1");
    ShapeSpace space = make_space(collection, options.space);
    RowMatrix coordinates = encode(space, collection);
    const auto angles = [&] { return companions(space, collection); };
    Eigen::VectorXd mesh_sizes = sizes(space, collection);
    return model_of({.topology = collection.topology,
                     .reference_points = collection.points.front(),
                     .space = space,
                     .names = collection.names,
                     .labels = collection.labels},
                    std::move(coordinates), angles, std::move(mesh_sizes), options);
}

namespace internal {

ShapeModel model_of(ModelFrame frame, RowMatrix coordinates,
                    const std::function<RowMatrix()>& angles_of, Eigen::VectorXd sizes,
                    const ModelOptions& options)
{
    PrincipalComponents components = principal_components(
        std::move(coordinates), {.modes = options.modes, .variance = options.variance});
    RowMatrix angles = angles_of();
    Eigen::VectorXd mean_angles = mean_of_rows(angles);
    return {.topology = std::move(frame.topology),
            .reference_points = std::move(frame.reference_points),
            .space = std::move(frame.space),
            .mean = std::move(components.mean),
            .mean_dihedral_angles = std::move(mean_angles),
            .modes = std::move(components.modes),
            .mode_dihedral_angles = companion_modes(components, std::move(angles)),
            .variances = std::move(components.variances),
            .total_variance = components.total_variance,
            .scores = std::move(components.scores),
            .sizes = std::move(sizes),
            .names = std::move(frame.names),
            .labels = std::move(frame.labels)};
}

} // namespace internal

DecodedShape model_point(const ShapeModel& model, const Eigen::VectorXd& scores, double size)
{
    const Eigen::Index count = scores.size();
    if (count > model.mode_count())
        throw InvalidInput(join("model point: ", count, " scores, the model has ",
                                counted(model.mode_count(), "mode")));
    for (Eigen::Index k = 0; k < count; ++k)
        if (!std::isfinite(scores[k]))
            throw InvalidInput(
                join("model point: score ", k, " is ", scores[k], ", must be finite"));
    return decode(model.space, with_rows_added(model.mean, model.modes, scores),
                  with_rows_added(model.mean_dihedral_angles, model.mode_dihedral_angles, scores),
                  size);
}

Projection project(const ShapeModel& model, const Collection& collection)
{
    if (!(collection.topology == model.topology))
        throw InvalidInput(
            join("projection: the meshes have another triangulation than the model; ",
                 describe_correspondence_break(
                     {"the model", "the model", model.reference_points, model.topology.faces()},
                     {collection.names.front(), "mesh " + collection.names.front(),
                      collection.points.front(), collection.topology.faces()})));
    SubspaceProjection projection =
        project_onto_subspace(encode(model.space, collection), model.mean, model.modes);
    return {.names = collection.names,
            .labels = collection.labels,
            .scores = std::move(projection.scores),
            .sizes = sizes(model.space, collection),
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
        std::sqrt(model.variances[mode]) * model.modes.row(mode).transpose();
    const auto reach = [&](const Eigen::VectorXd& direction) {
        return feasible_step(model.space, model.topology, model.mean, direction, limit);
    };
    return {.low = -reach(-deviation), .high = reach(deviation)};
}

} // namespace shape
