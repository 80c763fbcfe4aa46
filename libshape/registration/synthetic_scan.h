// SPDX-License-Identifier: MIT

#pragma once

#include <cstdint>
#include <vector>

#include "libshape/mesh/points.h"
#include "libshape/mesh/topology.h"
#include "libshape/registration/scan.h"

namespace shape {

/// What is wrong with a made-up scan.
struct SyntheticScanOptions
{
    /// The scan has about this many vertices, before holes; >= 50. 0: as many as the mesh has.
    int vertices = 0;
    /// Every vertex moves along its normal by a normal deviate of this standard deviation [mean edges of
    /// the scan]; >= 0.
    double noise = 0.0;
    /// It has this many holes, each a ball around a random vertex; >= 0.
    int holes = 0;
    /// Radius of the holes [share of the diagonal]; > 0.
    double hole_radius = 0.03;
    /// Beyond a plane of random direction the scan ends; share of the vertices that this costs, in [0, 0.9].
    double cut = 0.0;
    /// All that is random depends on this.
    std::uint64_t seed = 1;
};

/// @throws InvalidInput naming the first field that breaks its rule.
void check(const SyntheticScanOptions& options);

/// A raw scan of a surface whose vertices are known: another triangulation of it, of about equal edges,
/// that knows nothing of the first (edges split, collapsed and flipped, vertices moved within the surface
/// and back onto it: Botsch and Kobbelt 2004; vertices of a rim stay on it), with noise, holes and a cut.
/// @throws InvalidInput if an option breaks its rule.
/// Cost: about 1 s for 10,000 vertices. Deterministic.
[[nodiscard]] Scan synthetic_scan(const Topology& topology, const Points& points,
                                  const SyntheticScanOptions& options = {});

/// Vertices far from each other and from the boundary, as landmarks: each the farthest along the edges from
/// those before it and the boundary; of a closed mesh, the first is the farthest from the centroid.
/// @param count  In [1, #V].
/// @throws InvalidInput if it is not.
/// Cost: O(count #E log #V).
[[nodiscard]] std::vector<int> spread_vertices(const Topology& topology, const Points& points,
                                               int count);

} // namespace shape
