// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>

#include "libshape/base/progress.h"
#include "libshape/mesh/points.h"
#include "libshape/mesh/topology.h"

namespace shape {

/// The defaults are those of SciPy's fmin_l_bfgs_b, which the paper used.
struct DihedralSolverOptions
{
    int memory = 10;                  ///< Pairs kept by L-BFGS; >= 1.
    double gradient_tolerance = 1e-5; ///< Converged if max_e |dE/dd_e| <= this [1/rad]; >= 0.
    double decrease_tolerance =
        2.2e-9;                 ///< Converged if a step lowers E by <= this * max(1, E); >= 0.
    int max_iterations = 15000; ///< Not converged after more steps than this; >= 0.
};

struct DihedralSolution
{
    Eigen::VectorXd dihedral_angles; ///< #E [rad].
    double energy = 0.0;             ///< E (Rojas 2014, eq. 3) [1].
    double gradient_maximum = 0.0;   ///< max_e |dE/dd_e| [1/rad].
    int iterations = 0;
    int evaluations = 0;    ///< Of E and its gradient.
    bool converged = false; ///< One of the two inequalities above holds.
};

/// Dihedral angles that close the walk around every interior vertex: lowers E (closure.h) by L-BFGS
/// from an initial guess (Rojas 2014, section 2.1). E has many local minima; the one that is
/// found, zero or not, depends on the guess.
/// @param corner_angles  #F by 3 [rad].
/// @param initial  #E [rad], finite. Boundary edges keep their values.
/// @param progress  Called after every step with (iterations, max_iterations).
/// @throws InvalidInput if a size, a value or an option breaks a rule above.
/// Source: Rojas 2014; L-BFGS of libLBFGS (Nocedal 1980; More and Thuente 1994).
[[nodiscard]] DihedralSolution solve_dihedrals(const Topology& topology,
                                               const Points& corner_angles,
                                               const Eigen::VectorXd& initial,
                                               const DihedralSolverOptions& options = {},
                                               const Progress& progress = {});

} // namespace shape
