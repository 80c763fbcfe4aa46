// SPDX-License-Identifier: MIT

#pragma once

#include <cstdint>

#include "libshape/model/shape_model.h"

namespace shape {

/// The model of the meshes of a model and further ones, without the former: what fit_model() gives of
/// all together, to 1e-10 of its largest entries.
///
/// A model whose modes hold all variance but 1e-12 of it, so of all N - 1 modes or of meshes of which some are equal,
/// knows its meshes as points of the space, mean + scores modes, and their angles; one that has left more out does not,
/// and no method could give the same without reading the meshes again. What is less than 1e-12 of the variance is
/// rounding as a rule; were it more, scores of the former meshes would be off by up to 1e-6 of their spread.
///
/// @param options  What is kept of the result; the space is that of the model.
/// @throws InvalidInput if the modes of the model hold less; its space took weights from its collection
///     (area, dihedral angles, Procrustes), which further meshes would change; the meshes have another
///     triangulation or a name that the model has; or as fit_model().
/// Memory: update_memory().
[[nodiscard]] ShapeModel update_model(const ShapeModel& model, const Collection& added,
                                      const ModelOptions& options = {});

/// What the model, the positions of the meshes that are added, and update_model() take together, at most [byte].
[[nodiscard]] std::uint64_t update_memory(const ShapeModel& model, Eigen::Index added,
                                          const ModelOptions& options = {});

} // namespace shape
