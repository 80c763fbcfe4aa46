// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>

#include "libshape/mesh/points.h"
#include "libshape/mesh/topology.h"

namespace shape::internal {

/// dihedral_angles() into memory that is there: #E [rad] in (-pi, pi], boundary edges 0.
/// @throws InvalidInput if points does not have one row per vertex.
void measure_dihedral_angles(const Topology& topology, const Points& points,
                             Eigen::Ref<Eigen::VectorXd> angles);

} // namespace shape::internal
