// SPDX-License-Identifier: MIT

#include "libshape/embedding/residual_field.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/mesh/dihedral_angles.h"
#include "libshape/mesh/edge_lengths.h"

namespace shape {

ResidualField residual_field(const Topology& topology, const Points& points,
                             const ShapePoint& target)
{
    if (target.edge_lengths.size() != topology.edge_count() ||
        target.dihedral_angles.size() != topology.edge_count())
        throw InvalidInput(join("target has ", target.edge_lengths.size(), " lengths and ",
                                target.dihedral_angles.size(), " dihedral angles, the topology ",
                                topology.edge_count(), " edges"));
    const Eigen::VectorXd lengths = edge_lengths(topology, points);
    const Eigen::VectorXd angles = dihedral_angles(topology, points);
    ResidualField field{Eigen::VectorXd::Zero(topology.vertex_count()),
                        Eigen::VectorXd::Zero(topology.vertex_count())};
    for (int e = 0; e < topology.edge_count(); ++e) {
        const double error = std::abs(lengths[e] - target.edge_lengths[e]) / target.edge_lengths[e];
        const double drift =
            topology.is_boundary_edge(e)
                ? 0.0
                : 180.0 / std::numbers::pi *
                      std::abs(wrapped_angle(angles[e] - target.dihedral_angles[e]));
        for (const int v : topology.edges().row(e)) {
            field.edge_error[v] = std::max(field.edge_error[v], error);
            field.dihedral_drift[v] = std::max(field.dihedral_drift[v], drift);
        }
    }
    return field;
}

} // namespace shape
