// SPDX-License-Identifier: MIT

#pragma once

#include <cstddef>
#include <functional>

#include "libshape/edge_space/shape_space.h"
#include "libshape/mesh/mesh_stream.h"

// What shape_space.h does with a collection, for meshes that come block by block.

namespace shape::internal {

/// The space of the meshes, to the same bits as make_space() gives it.
/// @param block  Meshes that are in memory at a time.
/// @throws InvalidInput as make_space(), and for Procrustes space, whose mean takes all meshes together.
/// Cost: no pass for plain coordinates, one for what is taken from the collection, some more for positions, one a round of alignment.
[[nodiscard]] ShapeSpace make_space(const MeshStream& meshes, const SpaceOptions& options,
                                    Eigen::Index block);

/// Shows all meshes once, in their order, in one part or several.
using EachPart = std::function<void(const std::function<void(const Collection&)>& visit)>;

/// The edge space of meshes that come in parts: what both make_space() call.
/// @param options  Checked, of edge space.
[[nodiscard]] EdgeSpace make_edge_space(const Topology& topology, std::size_t meshes,
                                        const SpaceOptions& options, const EachPart& each_part);

/// encode() and sizes() at once, the lengths measured once.
void encode(const ShapeSpace& space, const Collection& block, RowMatrix& coordinates,
            Eigen::VectorXd& sizes);

/// D.
[[nodiscard]] Eigen::Index dimension(const ShapeSpace& space, const Topology& topology);

/// Whether points of the space have companion angles.
[[nodiscard]] bool has_companions(const ShapeSpace& space);

} // namespace shape::internal
