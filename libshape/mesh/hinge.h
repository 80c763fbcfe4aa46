// SPDX-License-Identifier: MIT

#pragma once

#include <array>
#include <cmath>
#include <numbers>

#include "libshape/base/vector3.h"
#include "libshape/mesh/topology.h"

namespace shape::internal {

// A hinge, an edge a-b with the triangles a b c on its left and b a d on its right, seen from outside:
//
//              c
//            / | `-.         Of the triangle a b c: l = |b - a|, h its height over the edge, f from a to the
//           /  h    `-.      foot of c along the edge, n its normal, |n| = l h.
//          a -f+------- b
//           `-.     .-'      The dihedral angle theta turns the left normal into the right one about b - a:
//              ` d '         0 is flat, > 0 convex.
//
// Moved corners change theta by the sum over both triangles of
//
//     (1 / h) ( (1 - f / l) q_a  +  (f / l) q_b  -  q_c ),      q_x = (n / |n|) . dx,
//
// which kernels take in three forms, by what they have at hand; one is the other but for rounding:
// HingeShares (l and f), HingeSlopes (1 / h and f / (l h)), bend_by_cotangents (l theta').
// Every number may be eight or four floats in SIMD lanes.

/// Its corners a, b, c, d; d is -1 on the boundary.
[[nodiscard]] inline std::array<int, 4> hinge_corners(const Topology& topology, int edge)
{
    const int left = topology.edge_halfedges()(edge, 0);
    const int right = topology.edge_halfedges()(edge, 1);
    return {topology.source(left), topology.target(left), topology.source(Topology::previous(left)),
            right < 0 ? -1 : topology.source(Topology::previous(right))};
}

/// The normals n of both triangles.
template <class Number>
struct HingeNormals
{
    Vector3<Number> left, right;
};
/// @param edge, left, right  b - a, c - a, d - a.
template <class Number>
[[gnu::always_inline]] inline HingeNormals<Number> hinge_normals(const Vector3<Number>& edge,
                                                                 const Vector3<Number>& left,
                                                                 const Vector3<Number>& right)
{
    return {cross(edge, left), cross(right, edge)};
}

/// An angle as a vector of any length in its direction; 0 where it is not defined.
template <class Number>
struct AngleVector
{
    Number sine, cosine;
};

/// theta from the edge b - a, its length, and normals of any length.
template <class Number>
[[gnu::always_inline]] inline AngleVector<Number> hinge_angle(const Vector3<Number>& edge,
                                                              const Number& length,
                                                              const Vector3<Number>& left,
                                                              const Vector3<Number>& right)
{
    return {dot(edge, cross(left, right)), length * dot(left, right)};
}

/// theta less an angle of that sine and cosine.
template <class Number, class Scalar>
[[gnu::always_inline]] inline AngleVector<Number> turned_back(const AngleVector<Number>& angle,
                                                              const Scalar& sine,
                                                              const Scalar& cosine)
{
    return {cosine * angle.sine - sine * angle.cosine, cosine * angle.cosine + sine * angle.sine};
}

/// The angle of a vector, in (-pi, pi] [rad]; 0 of the vector 0, where atan2(0, -0) would be pi.
[[nodiscard]] inline double angle_of(const AngleVector<double>& vector)
{
    if (vector.sine == 0.0 && vector.cosine == 0.0)
        return 0.0;
    const double angle = std::atan2(vector.sine, vector.cosine);
    return angle <= -std::numbers::pi ? std::numbers::pi : angle;
}

/// f from the lengths of the edge and of the sides at a and at b; 0 of an edge without length.
[[gnu::always_inline]] inline double foot_of(double length, double square, double square_at_a,
                                             double square_at_b)
{
    return length > 0.0 ? 0.5 * (square + square_at_a - square_at_b) / length : 0.0;
}

/// d theta / d(a, b, c) as multiples of n / |n|^2.
template <class Number>
struct HingeShares
{
    Number a, b, c;
};
template <class Number>
[[gnu::always_inline]] inline HingeShares<Number> hinge_shares(const Number& length,
                                                               const Number& foot)
{
    return {length - foot, foot, -length};
}

/// The same as multiples of n / |n|: height - foot, foot, -height.
template <class Number>
struct HingeSlopes
{
    Number height; ///< 1 / h.
    Number foot;   ///< f / (l h).
};
/// @param edge, before  b - a, a - c.
/// @param square  l^2, > 0.
/// @param inverse_area  1 / |n|.
template <class Number>
[[gnu::always_inline]] inline HingeSlopes<Number> hinge_slopes(const Vector3<Number>& edge,
                                                               const Vector3<Number>& before,
                                                               const Number& square,
                                                               const Number& inverse_area)
{
    using std::sqrt;
    const Number inverse_height = sqrt(square) * inverse_area;
    return {inverse_height, inverse_height * -dot(edge, before) / square};
}
/// A triangle's part in the change of theta.
/// @param a, b, c  q of the corners.
template <class Number>
[[gnu::always_inline]] inline Number bend_by_slopes(const HingeSlopes<Number>& slopes,
                                                    const Number& a, const Number& b,
                                                    const Number& c)
{
    return slopes.height * (a - c) + slopes.foot * (b - a);
}

/// l times that, from the cotangents f / h and (l - f) / h of the triangle's angles at a and at b.
template <class Number>
[[gnu::always_inline]] inline Number bend_by_cotangents(const Number& cotangent_a,
                                                        const Number& cotangent_b, const Number& a,
                                                        const Number& b, const Number& c)
{
    return cotangent_b * (a - c) + cotangent_a * (b - c);
}

} // namespace shape::internal
