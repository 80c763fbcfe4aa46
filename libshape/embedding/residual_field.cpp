// SPDX-License-Identifier: MIT

#include "libshape/embedding/residual_field.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/edge_space/admissibility.h"
#include "libshape/mesh/dihedral_angles.h"
#include "libshape/mesh/edge_lengths.h"

namespace shape {
using namespace internal;

EdgeResiduals edge_residuals(const Topology& topology, const Points& points,
                             const ShapePoint& target)
{
    if (target.edge_lengths.size() != topology.edge_count() ||
        target.dihedral_angles.size() != topology.edge_count())
        throw InvalidInput(join("target has ", target.edge_lengths.size(), " lengths and ",
                                target.dihedral_angles.size(), " dihedral angles, the topology ",
                                topology.edge_count(), " edges"));
    constexpr double degrees = 180.0 / std::numbers::pi;
    const Eigen::VectorXd angles = dihedral_angles(topology, points);
    EdgeResiduals residuals;
    residuals.edge_error = (edge_lengths(topology, points) - target.edge_lengths)
                               .cwiseAbs()
                               .cwiseQuotient(positive_lengths(target.edge_lengths));
    residuals.dihedral_drift = Eigen::VectorXd::Zero(topology.edge_count());
    for (int e = 0; e < topology.edge_count(); ++e)
        if (!topology.is_boundary_edge(e))
            residuals.dihedral_drift[e] =
                degrees * std::abs(wrapped_angle(angles[e] - target.dihedral_angles[e]));
    return residuals;
}

ResidualField residual_field(const Topology& topology, const Points& points,
                             const ShapePoint& target)
{
    return residual_field(topology, edge_residuals(topology, points, target));
}

ResidualField residual_field(const Topology& topology, const EdgeResiduals& residuals)
{
    ResidualField field{Eigen::VectorXd::Zero(topology.vertex_count()),
                        Eigen::VectorXd::Zero(topology.vertex_count())};
    for (int e = 0; e < topology.edge_count(); ++e)
        for (const int v : topology.edges().row(e)) {
            field.edge_error[v] = std::max(field.edge_error[v], residuals.edge_error[e]);
            field.dihedral_drift[v] =
                std::max(field.dihedral_drift[v], residuals.dihedral_drift[e]);
        }
    return field;
}

} // namespace shape
