// SPDX-License-Identifier: MIT

#include "libshape/embedding/start/face_layout.h"

#include <cmath>
#include <utility>

#include "libshape/base/blocks.h"
#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/to_size.h"
#include "libshape/base/vector_math.h"
#include "libshape/base/vectorised.h"
#include "libshape/embedding/start/quaternion_rows.h"
#include "libshape/mesh/triangle_area.h"

namespace shape::internal {
namespace {

using Eigen::Quaterniond;
using Eigen::VectorXd;

/// Faces with sides a, b, c: the third corner, from the second (p, y) and from the first (q, y),
///
///     p = (c^2 - a^2 - b^2) / (2 a),     q = (a^2 + c^2 - b^2) / (2 a),     y = 4 A / (2 a),
///
/// where A is the area; |p| <= b and |q| <= c are kept where the inequality is broken, then y = 0.
///
///              3
///         c  .' \  b        In memory a side of 128 faces is a row: a0 a1 .. a127. The plain loop has
///          .'    \          branches for broken faces, which keep it in one lane; here these are choices
///        1 ------- 2        between values.
///             a
SHAPE_VECTORISED void third_corners(int count, const double* a, const double* b, const double* c,
                                    double* __restrict p, double* __restrict q,
                                    double* __restrict y)
{
    const auto within = [](double x, double most) {
        return x < -most ? -most : x > most ? most : x;
    };
    for (int i = 0; i < count; ++i) {
        const double half = 0.5 / a[i];
        const double aa = a[i] * a[i], bb = b[i] * b[i], cc = c[i] * c[i];
        const double square = sixteen_squared_areas(a[i], b[i], c[i]);
        p[i] = within((cc - aa - bb) * half, b[i]);
        q[i] = within((aa + cc - bb) * half, c[i]);
        y[i] = (square > 0.0 ? std::sqrt(square) : 0.0) * half;
    }
}

/// Cosine and sine of half of an angle within (-pi, pi].
struct HalfAngle
{
    double cosine, sine;

    HalfAngle(double whole_cosine, double whole_sine)
    {
        const double large = std::sqrt(0.5 + 0.5 * std::abs(whole_cosine));
        const double small = 0.5 * std::abs(whole_sine) / large;
        const double absolute = whole_cosine < 0.0 ? large : small;
        cosine = whole_cosine < 0.0 ? small : large;
        sine = whole_sine < 0.0 ? -absolute : absolute;
    }
};

/// Half-edges in the planes of two neighbours.
struct Sides
{
    Row left_x, left_y, right_x, right_y;
};

/// Rz(h) Rx(t) Rz(pi - g): turn to the edge, bend about it, turn back from the opposite half-edge. As a
/// quaternion,
///
///     w = cos(t/2) sin((g - h)/2),     x =  sin(t/2) sin((g + h)/2),
///     z = cos(t/2) cos((g - h)/2),     y = -sin(t/2) cos((g + h)/2).
///
/// h and g are the directions of the two half-edges of an edge in the planes of their faces, of which
/// coordinates are known: halves of angles come by roots (HalfAngle), without angles. In memory a number
/// of 128 edges is a row. The plain product of three quaternions takes 32 multiplications and calls
/// functions of angles, one edge at a time.
/// @param sines, cosines  Of t / 2.
SHAPE_VECTORISED void transitions_of(int count, const Sides& sides, const double* lengths,
                                     const Row& sines, const Row& cosines,
                                     QuaternionRows& __restrict turns)
{
    for (int i = 0; i < count; ++i) {
        const double inverse = 1.0 / lengths[i];
        const HalfAngle h(inverse * sides.left_x[i], inverse * sides.left_y[i]);
        const HalfAngle g(inverse * sides.right_x[i], inverse * sides.right_y[i]);
        turns.w[i] = cosines[i] * (h.cosine * g.sine - h.sine * g.cosine);
        turns.x[i] = sines[i] * (h.cosine * g.sine + h.sine * g.cosine);
        turns.y[i] = sines[i] * (h.sine * g.sine - h.cosine * g.cosine);
        turns.z[i] = cosines[i] * (h.cosine * g.cosine + h.sine * g.sine);
    }
}

} // namespace

FaceLayout lay_out_faces(const Topology& topology, const VectorXd& lengths,
                         const VectorXd& dihedral_angles, FaceLayout memory)
{
    if (lengths.size() != topology.edge_count() || dihedral_angles.size() != topology.edge_count())
        throw InvalidInput(join("face layout: ", lengths.size(), " lengths and ",
                                dihedral_angles.size(), " dihedral angles for ",
                                topology.edge_count(), " edges"));
    FaceLayout layout = std::move(memory);
    layout.sides.resize(4, topology.face_count());
    for_blocks(topology.face_count(), [&](int first, int count) {
        Row a{}, b{}, c{}, p, q, y;
        for (int i = 0; i < count; ++i) {
            const int* const edges = topology.face_edges().data() + 3 * (first + i);
            a[i] = lengths[edges[0]];
            b[i] = lengths[edges[1]];
            c[i] = lengths[edges[2]];
        }
        third_corners(count, a, b, c, p, q, y);
        for (int i = 0; i < count; ++i)
            layout.sides.col(first + i) << a[i], p[i], -q[i], y[i];
    });
    layout.transitions.resize(to_size(topology.edge_count()));
    for_blocks(topology.edge_count(), [&](int first, int count) {
        Row halves{}, sines, cosines;
        Sides sides;
        QuaternionRows turns;
        for (int i = 0; i < count; ++i) {
            const int* const halfedges = topology.edge_halfedges().data() + 2 * (first + i);
            const Eigen::Vector2d left = layout.halfedge(halfedges[0]);
            const Eigen::Vector2d right = layout.halfedge(halfedges[halfedges[1] < 0 ? 0 : 1]);
            sides.left_x[i] = left.x();
            sides.left_y[i] = left.y();
            sides.right_x[i] = right.x();
            sides.right_y[i] = right.y();
            halves[i] = 0.5 * dihedral_angles[first + i];
        }
        sines_cosines(halves, to_size(count), sines, cosines);
        transitions_of(count, sides, lengths.data() + first, sines, cosines, turns);
        for (int i = 0; i < count; ++i)
            layout.transitions[to_size(first + i)] =
                topology.is_boundary_edge(first + i) ? Quaterniond::Identity() : turns.get(i);
    });
    return layout;
}

VectorXd closure_angles(const Topology& topology, const Rotations& transitions)
{
    VectorXd angles(topology.vertex_count());
    for_blocks(topology.vertex_count(), [&](int first, int count) {
        Row sines{}, cosines{}; // of half the angles
        for (int i = 0; i < count; ++i) {
            Quaterniond walk = Quaterniond::Identity();
            if (!topology.is_boundary_vertex(first + i))
                for (const int h : topology.outgoing(first + i)) {
                    const int e = topology.face_edges().data()[h];
                    // The faces come counter-clockwise: from right to left.
                    const bool forward = h != topology.edge_halfedges()(e, 0);
                    walk = followed_by(walk, transitions[to_size(e)], forward);
                }
            sines[i] = walk.vec().norm();
            cosines[i] = std::abs(walk.w());
        }
        vector_angles(sines, cosines, to_size(count), angles.data() + first);
        angles.segment(first, count) *= 2.0;
    });
    return angles;
}

} // namespace shape::internal
