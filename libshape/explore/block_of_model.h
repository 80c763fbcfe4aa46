// SPDX-License-Identifier: MIT

#pragma once

#include "libshape/base/progress.h"
#include "libshape/explore/model_block.h"
#include "libshape/model/shape_model.h"

namespace shape::internal {

/// Vertices move along this many modes to first order: what those beyond explain a sweep finds.
inline constexpr int most_linear_modes = 64;

/// @param modes  How many of the model's, from the first on; at most K.
/// @throws InvalidInput if there are directions in Procrustes space, or of another size.
/// Cost: that of a DihedralEmbedder and of two previews a mode and direction.
[[nodiscard]] ModelBlock make_block(const ShapeModel& model, int modes,
                                    AddedDirections directions = {},
                                    double smoothness = usual_smoothness,
                                    const Progress& progress = {});

} // namespace shape::internal
