// SPDX-License-Identifier: MIT

#include "libshape/mesh/dihedral_angles.h"

#include <cmath>
#include <numbers>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/mesh/hinge.h"

namespace shape {
using namespace internal;
namespace {

double turning_angle(const Vector3<double>& edge, const Vector3<double>& left,
                     const Vector3<double>& right)
{
    return angle_of(hinge_angle(edge, std::sqrt(dot(edge, edge)), left, right));
}

} // namespace

double dihedral_angle(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
                      const Eigen::Vector3d& d)
{
    const Vector3<double> from = vector3(a.data());
    const Vector3<double> edge = vector3(b.data()) - from;
    const auto [left, right] =
        hinge_normals(edge, vector3(c.data()) - from, vector3(d.data()) - from);
    return turning_angle(edge, left, right);
}

Eigen::VectorXd dihedral_angles(const Topology& topology, const Points& points)
{
    if (points.rows() != topology.vertex_count())
        throw InvalidInput(join("points has ", points.rows(), " rows, the topology ",
                                topology.vertex_count(), " vertices"));
    const auto point = [&](int v) { return vector3(points.data() + 3 * v); };
    const Faces& faces = topology.faces();
    Points normals(faces.rows(), 3);
    for (Eigen::Index f = 0; f < faces.rows(); ++f) {
        const Vector3<double> corner = point(faces(f, 0));
        store(cross(point(faces(f, 1)) - corner, point(faces(f, 2)) - corner),
              normals.data() + 3 * f);
    }
    const Edges& edges = topology.edges();
    const Edges& halfedges = topology.edge_halfedges();
    Eigen::VectorXd angles = Eigen::VectorXd::Zero(edges.rows());
    for (Eigen::Index e = 0; e < edges.rows(); ++e)
        if (halfedges(e, 1) >= 0)
            angles[e] =
                turning_angle(point(edges(e, 1)) - point(edges(e, 0)),
                              vector3(normals.data() + 3 * Topology::face(halfedges(e, 0))),
                              vector3(normals.data() + 3 * Topology::face(halfedges(e, 1))));
    return angles;
}

double wrapped_angle(double angle)
{
    const double wrapped = std::remainder(angle, 2.0 * std::numbers::pi);
    return wrapped <= -std::numbers::pi ? std::numbers::pi : wrapped;
}

} // namespace shape
