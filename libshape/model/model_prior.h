// SPDX-License-Identifier: MIT

#pragma once

#include "libshape/edge_space/shape_prior.h"
#include "libshape/model/shape_model.h"

namespace shape {

/// What a model expects of a shape, at its mean size: scores are in standard deviations of its modes.
/// Exact for lengths as coordinates; linearised at the mean, by a standard deviation to either side, in other spaces.
/// The noise is 0.003 of its variance.
/// Cost: 2 K decoded points.
[[nodiscard]] ShapePrior prior_of(const ShapeModel& model);

} // namespace shape
