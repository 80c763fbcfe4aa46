// SPDX-License-Identifier: MIT

#pragma once

#include <array>

#include "libshape/embedding/eightfold_energy.h"
#include "libshape/linalg/eightfold_solve.h"

namespace shape {

struct EightfoldDescentOptions
{
    int newton_steps = 8;
    int linear_steps = 12; ///< In each of them.
    int halvings = 3;      ///< Times that a Newton step is halved if E does not fall.
};

/// descend() of descent.h for eight positions of a region in lock-step: a fixed number of
/// Gauss-Newton steps, each by a fixed number of conjugate gradient steps. A position whose energy
/// does not fall stays; so no energy rises.
/// @param preconditioner  Of the Laplacian of the moving vertices, weighted by 1 / l^2.
/// @param points  All vertices of the region, in units of energy.unit(); the moving ones are moved.
/// @return the energies.
std::array<float, Eightfold::lanes> descend(EightfoldEnergy& energy,
                                            const EightfoldSolve& preconditioner,
                                            EightfoldPoints& points,
                                            const EightfoldDescentOptions& options = {});

} // namespace shape
