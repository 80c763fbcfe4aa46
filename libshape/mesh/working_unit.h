// SPDX-License-Identifier: MIT

#pragma once

#include <cmath>

#include "libshape/mesh/edge_lengths.h"
#include "libshape/mesh/points.h"
#include "libshape/mesh/topology.h"

namespace shape::internal {

/// What a mesh is multiplied by where fourth powers of lengths and of their inverses are taken: 1 if its longest edge
/// is in [1e-12, 1e12], so that the bits of usual meshes stay, else the power of two that brings it into [0.5, 1).
[[nodiscard]] inline double working_unit(const Topology& topology, const Points& mesh)
{
    constexpr double usual = 1e12;
    const double longest = edge_lengths(topology, mesh).maxCoeff();
    if (longest >= 1.0 / usual && longest <= usual)
        return 1.0;
    int exponent = 0;
    (void)std::frexp(longest, &exponent);
    return std::ldexp(1.0, -exponent);
}

} // namespace shape::internal
