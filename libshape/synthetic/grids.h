// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <array>
#include <functional>
#include <vector>

#include "libshape/mesh/points.h"

/// Triangulations with almost equilateral triangles, and curves to lay them along.
namespace shape::internal::synthetic {

/// `list` as the rows of a matrix (#F by 3).
[[nodiscard]] Faces to_faces(const std::vector<std::array<int, 3>>& list);

/// A vertex of a disc: vertex `index` of the 6 * ring vertices of a ring (1 for ring 0).
struct DiscVertex
{
    int ring = 0;
    int index = 0;

    [[nodiscard]] double angle() const; ///< [rad] in [0, 2 pi).
};

/// A piece of the triangular lattice: `rings` hexagonal rings around a vertex.
struct Disc
{
    Faces faces; ///< Counter-clockwise where angles grow counter-clockwise.
    std::vector<DiscVertex> vertices;
};

[[nodiscard]] Disc disc(int rings);

/// A vertex of a tube with two rounded caps, seen on the straight circular one.
struct TubeVertex
{
    double along = 0.0; ///< Arc length on the axis [length], 0 to `length`, beyond it in the caps.
    double angle = 0.0; ///< Around the axis [rad].
    double fill = 1.0;  ///< Distance from the axis / radius [1]: 1 on the tube, to 0 in the caps.
};

/// A closed surface of genus 0: two discs as hemispheres and staggered rings between them.
struct Tube
{
    Faces faces; ///< Outwards where (axis, angle 0, angle pi/2) is right-handed.
    std::vector<TubeVertex> vertices;
};

struct TubeOptions
{
    /// The axis is this long without the caps [length]; > 0.
    double length = 1.0;
    /// The tube has this radius [length]; > 0.
    double radius = 1.0;
    /// It has about this many vertices; >= 1.
    int vertices = 1000;
    /// Triangles are this many times as long along the axis as equilateral ones; > 0.
    double stretch = 1.0;
};

/// @throws InvalidInput naming the first field that breaks its rule.
void check(const TubeOptions& options);

[[nodiscard]] Tube tube(const TubeOptions& options);

/// An orthonormal right-handed frame on a curve.
struct CurveFrame
{
    Eigen::Vector3d origin;  ///< [length]
    Eigen::Vector3d tangent; ///< The axis of the tube.
    Eigen::Vector3d normal;  ///< Where angle 0 points.
    Eigen::Vector3d binormal;

    /// The point at a distance from the axis and an angle around it.
    [[nodiscard]] Eigen::Vector3d around(double radius, double angle) const;
};

/// A line along +x that turns towards +y (angle 0 of the tube) along one circular arc.
struct Bend
{
    double start = 0.0;  ///< Arc length where the arc begins [length].
    double length = 1.0; ///< Arc length of the arc [length], > 0.
    double angle = 0.0;  ///< Turn [rad].
};

[[nodiscard]] CurveFrame frame_on(const Bend& bend, double along);

/// Positions of the vertices of a tube, one call each.
[[nodiscard]] Points place(const Tube& tube,
                           const std::function<Eigen::Vector3d(const TubeVertex&)>& position);

} // namespace shape::internal::synthetic
