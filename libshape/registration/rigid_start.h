// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <numbers>
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

/// Ways in which a template may lie on a scan, wherever either is and whatever their units. At the ratio of their sizes
/// (root mean square distance from the centroid): first, with the axes that it has, centroid on centroid; then those of
/// 24 turns between their principal axes and 40 spread over all rotations whose distances, both ways, the farthest fifth
/// left out, are least, each improved by iterated closest points on few samples. They differ by same_way or more from
/// each other and, unless the centroids lie a fifth of the size apart, from the first.
///
/// Then, of a scan that is a part of a shape, or has more than that, and whose size says little, at the ratio of the units
/// (change_of_unit()): the place that it has already and, where the two ratios differ by more than a tenth, others as
/// before.
///
/// Times some factor, a scan has the same starts but for that factor and rounding; those at the ratio of the units if the
/// factor is one of two units.
/// @param count  So many at each ratio at most; >= 1.
/// Cost: about 5e4 nearest points for each ratio. Deterministic.
[[nodiscard]] std::vector<Similarity> rigid_starts(const Surface& moving, const Surface& fixed,
                                                   int count);

/// The similarity that takes three or more points to others: the scale is the ratio of their spreads, the motion least
/// squares.
/// @param from, to  Of equal size, >= 3 rows, not on a line.
[[nodiscard]] Similarity landmark_start(const Points& from, const Points& to);

/// How many units of a scan make one of a template, judged by how many times as large the scan is: 1 up to 2.5 times,
/// either way; else the nearest ratio of two units (unit_ratio.h) if it lies within a factor of 2.5; else the ratio
/// itself.
/// @param ratio  > 0.
[[nodiscard]] double change_of_unit(double ratio);

/// Root of the sum of squared distances from the mean [length].
[[nodiscard]] double spread(const Points& points);

/// The angle of a rotation in [0, pi] [rad].
[[nodiscard]] double turn_angle(const Eigen::Matrix3d& rotation);

/// Ways to lie that are turned by less against each other are one [rad].
inline constexpr double same_way = 20.0 * std::numbers::pi / 180.0;

} // namespace shape::internal
