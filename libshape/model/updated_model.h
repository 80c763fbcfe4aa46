// SPDX-License-Identifier: MIT

#pragma once

#include "libshape/model/shape_model.h"

namespace shape {

/// The model of the meshes of a model and further ones, without the former: what fit_model() gives of
/// all together, to 1e-10 of its largest entries.
///
/// A model of all modes knows its meshes as points of the space, mean + scores modes, and their angles;
/// one that has left modes out does not, and no method could give the same without reading the meshes
/// again.
///
/// @param options  What is kept of the result; the space is that of the model.
/// @throws InvalidInput if the model has not all N - 1 modes; its space took weights from its collection
///     (area, dihedral angles, Procrustes), which further meshes would change; the meshes have another
///     triangulation or a name that the model has; or as fit_model().
/// Memory: as fit_model() of all meshes.
[[nodiscard]] ShapeModel update_model(const ShapeModel& model, const Collection& added,
                                      const ModelOptions& options = {});

} // namespace shape
