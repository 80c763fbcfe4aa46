// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>

#include "libshape/edge_space/shape_vectors.h"
#include "libshape/mesh/points.h"
#include "libshape/mesh/topology.h"

namespace shape {

/// Where a mesh differs from the lengths and dihedral angles that it was made from. The largest
/// values are the `edge_max` and `dihedral_max_deg` of measure_embedding().
struct ResidualField
{
    Eigen::VectorXd edge_error;     ///< #V; the largest |l - l*| / l* of the edges at a vertex [1].
    Eigen::VectorXd dihedral_drift; ///< #V; the largest |theta - theta*|, wrapped, of the interior
                                    ///< edges at a vertex [deg]; 0 if it has none.
};

/// @throws InvalidInput if points or target do not fit the topology.
[[nodiscard]] ResidualField residual_field(const Topology& topology, const Points& points,
                                           const ShapePoint& target);

} // namespace shape
