// SPDX-License-Identifier: MIT

#include "libshape/mesh/dihedral_angles.h"

#include <cmath>
#include <numbers>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/gathered_vectors.h"
#include "libshape/base/to_size.h"
#include "libshape/base/vector_math.h"
#include "libshape/base/vectorised.h"
#include "libshape/mesh/hinge.h"
#include "libshape/mesh/measured_angles.h"

namespace shape {
using namespace internal;
namespace {

/// Vectors in the direction of the angles of hinges, from edges e and normals n, m left and right:
///
///     (sine, cosine) = (e . (n x m), |e| n . m)      (mesh/hinge.h).
///
/// In memory a coordinate of 128 hinges is a row, edges.x: x0 x1 .. x127. The plain loop over edges takes
/// products of three coordinates and an atan2 at a time; here a lane is a hinge, and vector_angles() takes
/// the row of vectors afterwards.
SHAPE_VECTORISED void hinge_angles(int count, const VectorRows& edges, const VectorRows& left,
                                   const VectorRows& right, double* __restrict sines,
                                   double* __restrict cosines)
{
    for (int i = 0; i < count; ++i) {
        const Vector3<double> edge = edges[i];
        const auto angle = hinge_angle(edge, std::sqrt(dot(edge, edge)), left[i], right[i]);
        sines[i] = angle.sine;
        cosines[i] = angle.cosine;
    }
}

} // namespace

double dihedral_angle(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
                      const Eigen::Vector3d& d)
{
    const Vector3<double> from = vector3(a.data());
    const Vector3<double> edge = vector3(b.data()) - from;
    const auto [left, right] =
        hinge_normals(edge, vector3(c.data()) - from, vector3(d.data()) - from);
    return angle_of(hinge_angle(edge, std::sqrt(dot(edge, edge)), left, right));
}

Eigen::VectorXd dihedral_angles(const Topology& topology, const Points& points)
{
    Eigen::VectorXd angles(topology.edge_count());
    measure_dihedral_angles(topology, points, angles);
    return angles;
}

void internal::measure_dihedral_angles(const Topology& topology, const Points& points,
                                       Eigen::Ref<Eigen::VectorXd> angles)
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
    for_blocks(topology.edge_count(), [&](int first, int count) {
        int left_faces[block_size], right_faces[block_size];
        for (int i = 0; i < count; ++i) {
            const int e = first + i;
            left_faces[i] = Topology::face(halfedges(e, 0));
            right_faces[i] =
                Topology::face(halfedges(e, halfedges(e, 1) < 0 ? 0 : 1)); // flat at the boundary
        }
        const int* const ends = edges.data() + 2 * first;
        VectorRows along, left, right;
        gather_differences(count, points.data(), {ends + 1, 2}, {ends, 2}, along);
        gather(count, normals.data(), {left_faces}, left);
        gather(count, normals.data(), {right_faces}, right);
        Row sines, cosines;
        hinge_angles(count, along, left, right, sines, cosines);
        vector_angles(sines, cosines, to_size(count), angles.data() + first);
        for (int e = first; e < first + count; ++e)
            if (halfedges(e, 1) < 0)
                angles[e] = 0.0;
            else if (angles[e] <= -std::numbers::pi)
                angles[e] = std::numbers::pi;
    });
}

double wrapped_angle(double angle)
{
    if (std::abs(angle) < std::numbers::pi)
        return angle;
    const double wrapped = std::remainder(angle, 2.0 * std::numbers::pi);
    return wrapped <= -std::numbers::pi ? std::numbers::pi : wrapped;
}

} // namespace shape
