// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <vector>

#include "libshape/conformal/cotangent_system.h"
#include "libshape/conformal/intrinsic_triangulation.h"

namespace shape::internal {

/// Which factors and which edges may change.
struct ScaleFactorProblem
{
    std::vector<char> is_free;  ///< #V; the factors of the other vertices stay.
    std::vector<char> may_flip; ///< #E; edges that are kept Delaunay: interior ones, not in or at
                                ///< a removed star.
    int removed_vertex = -1;    ///< Its faces do not count; not free. -1 for none.
};

struct ScaleFactorOptions
{
    /// It ends where max |angle defect| <= tolerance [rad], > 0; and where rounding keeps steps from
    /// helping.
    double tolerance = 1e-13;
    /// It ends after this many Newton steps; >= 0.
    int max_iterations = 200;
};

/// @throws InvalidInput naming the first field that breaks its rule.
void check(const ScaleFactorOptions& options);

/// The minimiser of the angle-defect energy.
struct ScaleFactors
{
    IntrinsicTriangulation triangulation;
    Eigen::VectorXd u;             ///< #V log factors [1].
    double residual = 0.0;         ///< max |2 pi - angle sum| over the free vertices [rad].
    int iterations = 0;            ///< Newton steps, each with one factorisation.
    std::vector<int> broken_faces; ///< Faces that break the triangle inequality there: then no
                                   ///< solution exists with these edges. Ascending.
    Eigen::VectorXd edge_weights;  ///< #E half cotangent sums at u.
    CotangentSystem system;        ///< The system of the triangulation and its free vertices.
};

/// Finds the factors that make the angles at every free vertex sum to 2 pi: Newton's method on the
/// convex energy of angle_defect_energy.h, which has one minimiser. Edges that may flip are Delaunay
/// after every step; the energy is convex with them too (Springborn 2019; Gillespie, Springborn,
/// Crane 2021, section 3).
///
/// @param initial  #V.
/// Cost: 5 to 25 factorisations of a Laplacian.
[[nodiscard]] ScaleFactors solve_scale_factors(const IntrinsicTriangulation& triangulation,
                                               const Eigen::VectorXd& initial,
                                               const ScaleFactorProblem& problem,
                                               const ScaleFactorOptions& options = {});

} // namespace shape::internal
