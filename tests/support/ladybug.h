// SPDX-License-Identifier: MIT

#pragma once

#include "libshape/embedding/start/local_frames.h"
#include "libshape/mesh/points.h"
#include "libshape/mesh/topology.h"

namespace shape::test {
using namespace internal;

/// The ladybug's walk around an interior vertex, Z_0 X_0 ... Z_k X_k (Rojas 2014, eq. 1), turn by
/// turn. It closes if this is the identity.
[[nodiscard]] inline Eigen::Matrix3d walk_around(const Topology& topology,
                                                 const Points& corner_angles,
                                                 const Eigen::VectorXd& dihedral_angles, int vertex)
{
    Eigen::Matrix3d walk = Eigen::Matrix3d::Identity();
    const auto ring = topology.outgoing(vertex);
    for (std::size_t i = 0; i < ring.size(); ++i)
        walk = walk * turn_about_z(corner_angles(ring[i] / 3, ring[i] % 3)) *
               turn_about_x(-dihedral_angles[topology.edge(ring[(i + 1) % ring.size()])]);
    return walk;
}

} // namespace shape::test
