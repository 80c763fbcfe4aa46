// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>

#include "libshape/base/progress.h"
#include "libshape/linalg/lbfgs.h"
#include "libshape/mesh/points.h"
#include "libshape/mesh/topology.h"

namespace shape::internal {

struct DihedralSolution
{
    Eigen::VectorXd dihedral_angles; ///< #E [rad].
    double energy = 0.0;             ///< E (Rojas 2014, eq. 3) [1].
    double gradient_maximum = 0.0;   ///< max_e |dE/dd_e| [1/rad].
    int iterations = 0;
    int evaluations = 0;    ///< E and its gradient were evaluated this often.
    bool converged = false; ///< A tolerance of the options is met.
};

/// SciPy's fmin_l_bfgs_b, which the paper used, has memory 10 and gradient tolerance 1e-5;
/// docs/closure.md says why these differ.
inline constexpr LbfgsOptions dihedral_solver_defaults{
    .memory = 5, .gradient_tolerance = 5e-6, .decrease_tolerance = 1.5e-9, .max_iterations = 15000};

/// Dihedral angles that close the walk around every interior vertex: lowers E (closure.h) by L-BFGS
/// from an initial guess (Rojas 2014, section 2.1). E has many local minima; the one that is
/// found, zero or not, depends on the guess.
/// @param corner_angles  #F by 3 [rad].
/// @param initial  #E [rad], within 1e9. Boundary edges keep their values.
/// @param progress  Called after every step with (iterations, max_iterations).
/// @throws InvalidInput if a size, a value or an option breaks a rule.
/// Cost: O(#E) an iteration.
[[nodiscard]] DihedralSolution solve_dihedrals(
    const Topology& topology, const Points& corner_angles, const Eigen::VectorXd& initial,
    const LbfgsOptions& options = dihedral_solver_defaults, const Progress& progress = {});

} // namespace shape::internal
