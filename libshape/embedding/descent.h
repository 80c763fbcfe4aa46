// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>

#include "libshape/embedding/length_dihedral_energy.h"
#include "libshape/linalg/single_precision_solve.h"

namespace shape {

struct DescentOptions
{
    int max_linear_steps = 120; ///< In all; each is one back-substitution; >= 0.
    int first_linear_steps = 8; ///< In the first Newton step; >= 2.
    /// Converged once a Newton step of k linear steps lowers E by <= k * decrease_tolerance * E.
    double decrease_tolerance = 2e-4;
    double value_tolerance = 0.0; ///< Converged as well once E <= value_tolerance.
};

struct Descent
{
    Eigen::VectorXd points; ///< #V by 3, row by row in one vector [length].
    double energy = 0.0;
    int linear_steps = 0; ///< Of conjugate gradients: one product and one back-substitution each.
    bool converged = false;
};

/// Lowers a LengthDihedralEnergy by Gauss-Newton steps. Their linear systems are solved by conjugate
/// gradients (gauss_newton_operator.h), cut off early: at first_linear_steps first, half as many
/// again after a Newton step that did what its quadratic model said, half of them after one that did
/// not.
/// (Truncated Newton method: Nocedal and Wright 2006, section 7.1.) Newton steps are halved until E
/// falls, so E never rises.
/// @param preconditioner  Of the Laplacian weighted by 1 / l^2 (edge_laplacian.h).
/// @throws InvalidInput if an option is out of its range.
/// @throws NumericalError if E is not finite at the start.
[[nodiscard]] Descent descend(LengthDihedralEnergy& energy,
                              const SinglePrecisionSolve& preconditioner, Eigen::VectorXd start,
                              const DescentOptions& options = {});

} // namespace shape
