// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <vector>

#include "libshape/mesh/points.h"
#include "libshape/mesh/topology.h"

namespace shape::internal {

/// A topology whose neighbours lie next to each other in memory. Loops over faces and edges of large
/// meshes run two to three times faster on it.
struct Renumbering
{
    Topology topology;
    std::vector<int> vertices; ///< Entry i: what vertex i was before.
    std::vector<int> edges;    ///< Entry e: what edge e was before.
};

/// Vertices in breadth-first order from vertex 0, faces in that of their lowest vertex; the corners
/// of a face stay in order.
/// Cost: that of a Topology.
[[nodiscard]] Renumbering renumber_for_locality(const Topology& topology);

/// Points in the new order, and back.
[[nodiscard]] Points renumbered(const Renumbering& renumbering, const Points& points);
[[nodiscard]] Points restored(const Renumbering& renumbering,
                              const Eigen::Ref<const Points>& points);

/// Values of edges in the new order, #E.
[[nodiscard]] Eigen::VectorXd renumbered(const Renumbering& renumbering,
                                         const Eigen::VectorXd& values);

} // namespace shape::internal
