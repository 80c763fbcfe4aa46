// SPDX-License-Identifier: MIT

#pragma once

#include <array>

#include "libshape/embedding/energy/eight_lane_energy.h"
#include "libshape/linalg/eight_lane_solve.h"

namespace shape::internal {

struct EightLaneDescentOptions
{
    /// Every position takes this many Gauss-Newton steps; >= 0.
    int newton_steps = 5;
    /// Each of them is solved by this many conjugate gradient steps; >= 1.
    int linear_steps = 8;
    /// A Newton step is halved up to this many times where E does not fall, then not taken; >= 0.
    int halvings = 3;
};

/// @throws InvalidInput naming the first field that breaks its rule.
void check(const EightLaneDescentOptions& options);

/// descend() of descent.h for eight positions of a region in eight SIMD lanes: a fixed number of
/// Gauss-Newton steps, each by a fixed number of conjugate gradient steps. A position whose energy
/// does not fall stays; so no energy rises.
/// @throws InvalidInput if an option breaks its rule.
/// @param preconditioner  Of the Laplacian of the moving vertices, weighted by 1 / l^2.
/// @param points  All vertices of the region, in units of energy.unit(); the moving ones are moved.
/// @return the energies.
std::array<float, EightLanes::lanes> descend(EightLaneEnergy& energy,
                                             const EightLaneSolve& preconditioner,
                                             EightLanePoints& points,
                                             const EightLaneDescentOptions& options = {});

} // namespace shape::internal
