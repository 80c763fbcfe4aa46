// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>

#include "libshape/edge_space/shape_vectors.h"
#include "libshape/mesh/points.h"
#include "libshape/mesh/topology.h"

namespace shape {

/// How every edge of a mesh differs from what was wanted of it.
struct EdgeResiduals
{
    Eigen::VectorXd edge_error;     ///< #E; |l - l*| / l* [1], l* as in positive_lengths().
    Eigen::VectorXd dihedral_drift; ///< #E; |theta - theta*|, wrapped [deg]; 0 on the boundary.
};

/// @throws InvalidInput if points or target do not fit the topology.
[[nodiscard]] EdgeResiduals edge_residuals(const Topology& topology, const Points& points,
                                           const ShapePoint& target);

/// The same at vertices: the largest of their edges, 0 where there is none. The largest values are the
/// `edge_max` and `dihedral_max_deg` of measure_embedding().
struct ResidualField
{
    Eigen::VectorXd edge_error;     ///< #V [1].
    Eigen::VectorXd dihedral_drift; ///< #V [deg].
};

[[nodiscard]] ResidualField residual_field(const Topology& topology,
                                           const EdgeResiduals& residuals); ///< Cost: O(#E).

/// @throws InvalidInput if points or target do not fit the topology.
[[nodiscard]] ResidualField residual_field(const Topology& topology, const Points& points,
                                           const ShapePoint& target);

} // namespace shape
