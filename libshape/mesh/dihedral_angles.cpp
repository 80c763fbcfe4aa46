// SPDX-License-Identifier: MIT

#include "libshape/mesh/dihedral_angles.h"

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "libshape/base/error.h"
#include "libshape/base/format.h"

namespace shape {

double dihedral_angle(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
                      const Eigen::Vector3d& d)
{
    const Eigen::Vector3d axis = b - a;
    const Eigen::Vector3d left = axis.cross(c - a);
    const Eigen::Vector3d right = (d - a).cross(axis);
    const double angle = std::atan2(axis.dot(left.cross(right)), axis.norm() * left.dot(right));
    return angle <= -std::numbers::pi ? std::numbers::pi : angle;
}

Eigen::VectorXd dihedral_angles(const Topology& topology, const Points& points)
{
    if (points.rows() != topology.vertex_count())
        throw InvalidInput(join("points has ", points.rows(), " rows, the topology ",
                                topology.vertex_count(), " vertices"));
    Eigen::VectorXd angles = Eigen::VectorXd::Zero(topology.edge_count());
    const auto point = [&](int v) -> Eigen::Vector3d { return points.row(v).transpose(); };
    for (int e = 0; e < topology.edge_count(); ++e) {
        if (topology.is_boundary_edge(e))
            continue;
        const int left = topology.edge_halfedges()(e, 0);
        const int right = topology.edge_halfedges()(e, 1);
        angles[e] = dihedral_angle(point(topology.source(left)), point(topology.target(left)),
                                   point(topology.source(Topology::previous(left))),
                                   point(topology.source(Topology::previous(right))));
    }
    return angles;
}

double wrapped_angle(double angle)
{
    const double wrapped = std::remainder(angle, 2.0 * std::numbers::pi);
    return wrapped <= -std::numbers::pi ? std::numbers::pi : wrapped;
}

} // namespace shape
