// SPDX-License-Identifier: MIT

#pragma once

#include <functional>

#include "libshape/model/shape_model.h"

namespace shape::internal {

/// What a model has of its meshes as they are.
struct ModelFrame
{
    Topology topology;
    Points reference_points;
    ShapeSpace space;
    std::vector<std::string> names;
    Labels labels;
};

/// The model of meshes that are points of a space already.
/// @param coordinates  N by D.
/// @param angles_of  Makes their companions, N by #E or N by 0, when the coordinates are gone.
/// @param sizes  N.
/// @throws as principal_components().
[[nodiscard]] ShapeModel model_of(ModelFrame frame, RowMatrix coordinates,
                                  const std::function<RowMatrix()>& angles_of,
                                  Eigen::VectorXd sizes, const ModelOptions& options);

} // namespace shape::internal
