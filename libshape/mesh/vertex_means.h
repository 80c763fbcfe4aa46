// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>

#include "libshape/mesh/topology.h"

namespace shape {

/// Mean, at each vertex, of the values of its edges, #V.
/// @param edge_values  #E.
/// @throws InvalidInput if edge_values does not have one entry per edge.
[[nodiscard]] Eigen::VectorXd vertex_means(const Topology& topology,
                                           const Eigen::VectorXd& edge_values);

} // namespace shape
