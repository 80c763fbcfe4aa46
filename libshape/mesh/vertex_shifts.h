// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "libshape/mesh/points.h"
#include "libshape/mesh/topology.h"

namespace shape::internal {

/// How far some vertices of every mesh lie from the place that they have in most of the meshes among those around them.
struct VertexShifts
{
    std::vector<int> vertices; ///< Ascending.
    Eigen::MatrixXd shifts;    ///< A row a vertex, a column a mesh; >= 0 [1].
    Eigen::MatrixXd
        heights; ///< The same across that plane: change of the height over it; >= 0 [1].
};

/// The shell of v are the vertices `rings` edges away. Seen along the mean normal of the polygon of the shell, which v has
/// no part in, v is sum_k w_k s_k with sum_k w_k = 1, of (nearly) least sum w_k^2. The median of each w_k over the meshes, divided by
/// their sum, says where v belongs; the shift is the distance in that plane from there, by the mean distance of the
/// shell from its centroid. An affine map of the surroundings changes nothing of it and a crease little, as these are
/// what poses and other individuals do; where a vertex has taken the place of another, it is 1 and more for one ring.
/// The height of v over the centroid along the normal, by the same distance, is compared with its median over the meshes.
/// @param meshes  Each #V by 3. @param rings  >= 1. @param most  So many vertices are asked about, drawn evenly.
/// @return Without vertices of which the shell has fewer than three; 0 where all of it lies on one point, and shifts where the
///     medians of w_k have no sum.
/// Cost: O(N min(#V, most) rings).
[[nodiscard]] VertexShifts vertex_shifts(const Topology& topology, std::span<const Points> meshes,
                                         int rings, int most);

} // namespace shape::internal
