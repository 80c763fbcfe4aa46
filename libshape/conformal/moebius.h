// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <complex>

#include "libshape/conformal/compensated_points.h"

namespace shape::internal {

/// Similarity x -> (x - centre) / height of the plane before stereographic projection. Up to
/// rotations of the sphere these are all its Möbius transformations.
struct StereographicFrame
{
    std::complex<double> centre = 0.0;
    double height = 1.0; ///< > 0.
};

struct MoebiusBalance
{
    StereographicFrame frame;
    double residual = 0.0; ///< |sum_i w_i p_i|, p_i on the unit sphere, sum_i w_i = 1.
    int iterations = 0;    ///< Newton steps.
};

/// Finds the frame in which the weighted mean of the points on the sphere is 0 (Springborn 2005;
/// Baden, Crane, Kazhdan 2018): Newton's method in hyperbolic space on the convex
/// energy sum_i w_i (distance to p_i, at infinity, up to a constant). Unique up to rotations of the sphere.
///
/// @param weights  #V, > 0; no one may reach half of their sum.
/// @param infinite_vertex  Its position is the point at infinity.
[[nodiscard]] MoebiusBalance balance_on_sphere(const Eigen::VectorXcd& positions,
                                               const Eigen::VectorXd& weights, int infinite_vertex);

/// Inverse stereographic projection. The plane's origin goes to (0, 0, 1), its infinity to
/// (0, 0, -1); counter-clockwise stays counter-clockwise, seen from outside.
[[nodiscard]] SpherePoints project_to_sphere(const PlanarLayout& layout,
                                             const StereographicFrame& frame, int infinite_vertex);

} // namespace shape::internal
