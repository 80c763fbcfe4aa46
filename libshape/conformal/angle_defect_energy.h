// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "libshape/conformal/intrinsic_triangulation.h"

namespace shape::internal {

/// The convex energy of discrete conformal equivalence (Springborn, Schröder, Pinkall 2008,
/// section 5; Bobenko, Pinkall, Springborn 2015, section 4), in the log factors u:
///
///     E(u) = 2 pi sum_i u_i + sum_T (2 f(x_1, x_2, x_3) - pi (x_1 + x_2 + x_3)),
///     f(x) = sum_k (alpha_k x_k + L(alpha_k)),
///
/// x the scaled log lengths of a triangle, alpha_k the angle opposite side k, L Milnor's
/// Lobachevsky function. A triangle whose lengths break the triangle inequality has the angles pi
/// (opposite its longest side), 0 and 0; with that E is convex and once differentiable everywhere.
/// dE/du_i is 2 pi minus the angle sum at i, the Hessian is half the cotangent Laplacian. E does not change when an edge whose four vertices are concyclic is flipped.

/// L(x) = - integral from 0 to x of log |2 sin t| dt; odd, period pi. Absolute error below 1e-15.
[[nodiscard]] double lobachevsky(double x);

/// Angles of a triangle opposite its sides [rad], and half their cotangents [1].
struct TriangleAngles
{
    std::array<double, 3> angles{};
    std::array<double, 3> weights{}; ///< cot / 2; all 0 if broken.
    bool broken = false;             ///< The longest side is not shorter than the others together.
};

/// @param log_lengths  Of the three sides; only their differences matter.
[[nodiscard]] TriangleAngles triangle_angles(const std::array<double, 3>& log_lengths);

/// Sides of a face, scaled: entry c belongs to half-edge 3 face + c, as in triangle_angles().
[[nodiscard]] std::array<double, 3> scaled_sides(const IntrinsicTriangulation& triangulation,
                                                 const Eigen::VectorXd& u, int face);

/// E(u). Faces at `removed_vertex` (-1: none) do not count.
/// Same bits for any number of threads.
[[nodiscard]] double angle_defect_energy(const IntrinsicTriangulation& triangulation,
                                         const Eigen::VectorXd& u, int removed_vertex = -1);

/// First and second derivatives of E.
struct AngleDefects
{
    Eigen::VectorXd defects;      ///< #V [rad]: 2 pi minus the angle sum, the gradient of E; 0 at
                                  ///< the removed vertex.
    Eigen::VectorXd edge_weights; ///< #E [1]: half the sum of the cotangents opposite the edge, the
                                  ///< off-diagonal entries of the Hessian with opposite sign; but
                                  ///< 0.1 instead of 0 for broken faces, so that steps stay tame.
    std::vector<int> broken_faces; ///< Ascending.
};

/// Same bits for any number of threads.
[[nodiscard]] AngleDefects measure_angle_defects(const IntrinsicTriangulation& triangulation,
                                                 const Eigen::VectorXd& u, int removed_vertex = -1);

} // namespace shape::internal
