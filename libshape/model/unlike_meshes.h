// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>

#include "libshape/linalg/dense.h"
#include "libshape/mesh/collection.h"
#include "libshape/model/shape_model.h"

namespace shape::internal {

/// Marks new meshes that are unlike those of a model in what edge lengths do not see, or divide out: N by 3, each
/// 1 where a mesh is a mirror image of the model's reference mesh; more than 5 times as large as the
/// largest mesh of the model; less than a fifth of the smallest.
/// @param meshes  Of the model's triangulation.
/// @param sizes  Theirs, as project() measures them.
/// Cost: that of compare_handedness() of two meshes, for each.
[[nodiscard]] RowMatrix unlike_meshes(const ShapeModel& model, const Collection& meshes,
                                      const Eigen::VectorXd& sizes);

} // namespace shape::internal
