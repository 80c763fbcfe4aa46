// SPDX-License-Identifier: MIT

#pragma once

#include "libshape/edge_space/shape_space.h"
#include "libshape/embedding/embedder.h"
#include "libshape/mesh/topology.h"

namespace shape {

/// The shape at another size: lengths and positions times a factor.
/// @throws InvalidInput if the factor is not > 0 and finite.
[[nodiscard]] DecodedShape resized(DecodedShape shape, double factor);

/// An embedding brought to another size: its mesh times a factor, what is said of it in the lengths of that size.
///
/// Where several meshes are about as near to a target, rounding says which is found, and with it the size at which the
/// embedding runs. So embed a shape at one size, say the mean size of its model, and resize the mesh: it is the same at
/// every size, up to a rounding of its coordinates. By a factor of 1 nothing changes.
/// @param embedding  Of `shape`.
/// @throws InvalidInput if the factor is not > 0 and finite, or the longest edge of the target leaves [1e-60, 1e60] [length].
[[nodiscard]] Embedding resized(Embedding embedding, const Topology& topology,
                                const DecodedShape& shape, double factor);

} // namespace shape
