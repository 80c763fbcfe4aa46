// SPDX-License-Identifier: MIT

#pragma once

namespace shape {

/// How a triangulation without solution is repaired.
struct TriangulationRepairOptions
{
    int local_rounds = 20; ///< Repairs about broken faces before all edges are released; >= 0.
    int max_rounds = 100;  ///< Repairs in all; >= 0.
};

} // namespace shape
