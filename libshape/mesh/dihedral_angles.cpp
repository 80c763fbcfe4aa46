// SPDX-License-Identifier: MIT

#include "libshape/mesh/dihedral_angles.h"

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "libshape/base/error.h"
#include "libshape/base/format.h"

namespace shape {
using namespace internal;
namespace {

/// Angle in (-pi, pi] about `axis` from the normal on its left to that on its right, of any length.
double turning_angle(const Eigen::Vector3d& left, const Eigen::Vector3d& right,
                     const Eigen::Vector3d& axis)
{
    const double sine = axis.dot(left.cross(right));
    const double cosine = axis.norm() * left.dot(right);
    if (sine == 0.0 && cosine == 0.0) // a face without area; atan2(0, -0) would be pi
        return 0.0;
    const double angle = std::atan2(sine, cosine);
    return angle <= -std::numbers::pi ? std::numbers::pi : angle;
}

} // namespace

double dihedral_angle(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
                      const Eigen::Vector3d& d)
{
    const Eigen::Vector3d axis = b - a;
    return turning_angle(axis.cross(c - a), (d - a).cross(axis), axis);
}

Eigen::VectorXd dihedral_angles(const Topology& topology, const Points& points)
{
    if (points.rows() != topology.vertex_count())
        throw InvalidInput(join("points has ", points.rows(), " rows, the topology ",
                                topology.vertex_count(), " vertices"));
    const Faces& faces = topology.faces();
    Points normals(faces.rows(), 3);
    for (Eigen::Index f = 0; f < faces.rows(); ++f) {
        const Eigen::RowVector3d corner = points.row(faces(f, 0));
        normals.row(f) = (points.row(faces(f, 1)) - corner).cross(points.row(faces(f, 2)) - corner);
    }
    const Edges& edges = topology.edges();
    const Edges& halfedges = topology.edge_halfedges();
    Eigen::VectorXd angles = Eigen::VectorXd::Zero(edges.rows());
    for (Eigen::Index e = 0; e < edges.rows(); ++e)
        if (halfedges(e, 1) >= 0)
            angles[e] = turning_angle(normals.row(Topology::face(halfedges(e, 0))),
                                      normals.row(Topology::face(halfedges(e, 1))),
                                      points.row(edges(e, 1)) - points.row(edges(e, 0)));
    return angles;
}

double wrapped_angle(double angle)
{
    const double wrapped = std::remainder(angle, 2.0 * std::numbers::pi);
    return wrapped <= -std::numbers::pi ? std::numbers::pi : wrapped;
}

} // namespace shape
