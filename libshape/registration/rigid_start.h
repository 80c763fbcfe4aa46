// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <vector>

#include "libshape/mesh/alignment.h"
#include "libshape/mesh/points.h"
#include "libshape/registration/scan_surface.h"

namespace shape::internal {

/// x -> motion(scale * x).
struct Similarity
{
    double scale = 1.0; ///< > 0.
    RigidMotion motion;

    [[nodiscard]] Points operator()(const Points& points) const;
    [[nodiscard]] Points inverse(const Points& points) const;
};

/// Ways in which a template may lie on a scan, wherever either is: 24 turns between their principal
/// axes, 40 more spread over all rotations, and the place it has already, each improved by iterated
/// closest points on few samples; those whose distances, both ways, the farthest fifth left out, are
/// least. The first is the place it has already; the others differ by 20 degrees or more.
///
/// The scale is 1 if the sizes (root mean square distance from the centroid) differ by less than 2.5
/// times, else their ratio: a scan in metres, a template in millimetres.
/// @param count  So many at most; >= 1.
/// Cost: about 5e4 nearest points. Deterministic.
[[nodiscard]] std::vector<Similarity> rigid_starts(const Surface& moving, const Surface& fixed,
                                                   int count);

/// The similarity that takes three or more points to others, least squares; the scale by the same rule.
/// @param from, to  Of equal size, >= 3 rows, not on a line.
[[nodiscard]] Similarity landmark_start(const Points& from, const Points& to);

} // namespace shape::internal
