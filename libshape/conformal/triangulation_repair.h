// SPDX-License-Identifier: MIT

#pragma once

namespace shape {

/// How a triangulation without solution is repaired.
struct TriangulationRepairOptions
{
    /// After this many repairs about broken faces alone, all edges are released; >= 0.
    int local_rounds = 20;
    /// It ends after this many repairs in all; >= 0.
    int max_rounds = 100;
};

/// @throws InvalidInput naming the first field that breaks its rule.
void check(const TriangulationRepairOptions& options);

} // namespace shape
