// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <vector>

#include "libshape/conformal/cotangent_system.h"
#include "libshape/conformal/intrinsic_triangulation.h"

namespace shape {

struct ScaleFactorOptions
{
    double tolerance = 1e-13; ///< Converged when max |angle defect| <= tolerance [rad]; > 0. Steps
                              ///< also end where rounding lets them no longer help.
    int max_iterations = 200; ///< Newton steps; >= 0.
};

/// The minimiser of the angle-defect energy on one triangulation.
struct ScaleFactors
{
    Eigen::VectorXd u;             ///< #V log factors [1].
    double residual = 0.0;         ///< max |2 pi - angle sum| over the free vertices [rad].
    int iterations = 0;            ///< Newton steps, each with one factorisation.
    bool converged = false;        ///< residual <= 1e-12 and no face is broken.
    std::vector<int> broken_faces; ///< Faces that break the triangle inequality at the minimiser:
                                   ///< then no solution exists on this triangulation. Ascending.
    Eigen::VectorXd edge_weights;  ///< #E half cotangent sums at u.
};

/// Finds the factors that make the angles at every free vertex sum to 2 pi: Newton's method on the
/// convex energy of angle_defect_energy.h, which has one minimiser.
///
/// @param initial  #V; stays as it is where is_free is 0.
/// @param is_free  #V.
/// @param removed_vertex  Its faces do not count; -1 for none. Not free.
/// @param system  Of the same triangulation and is_free; holds the last factorisation afterwards.
[[nodiscard]] ScaleFactors solve_scale_factors(const IntrinsicTriangulation& triangulation,
                                               const Eigen::VectorXd& initial,
                                               const std::vector<char>& is_free,
                                               int removed_vertex, CotangentSystem& system,
                                               const ScaleFactorOptions& options = {});

} // namespace shape
