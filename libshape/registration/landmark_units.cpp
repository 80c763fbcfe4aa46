// SPDX-License-Identifier: MIT

#include "libshape/registration/landmark_units.h"

#include <algorithm>
#include <vector>

#include "libshape/base/format.h"
#include "libshape/base/order_statistics.h"
#include "libshape/mesh/unit_ratio.h"

namespace shape::internal {
namespace {

double largest_distance(const Points& landmarks, const Surface& surface)
{
    double distance = 0.0;
    for (const auto& landmark : landmarks.rowwise())
        distance = std::max(distance, surface.tree.nearest(landmark).distance);
    return distance;
}

/// How far landmarks spread, about their bounding box's diagonal, but not by fewer than half of them: a code for a
/// missing one lies far off.
double robust_spread(const Points& landmarks)
{
    Eigen::RowVector3d middle;
    for (int axis = 0; axis < 3; ++axis)
        middle[axis] = median({landmarks.col(axis).begin(), landmarks.col(axis).end()});
    const Eigen::VectorXd distances = (landmarks.rowwise() - middle).rowwise().norm();
    return 2.0 * median({distances.begin(), distances.end()});
}

} // namespace

std::optional<std::string> other_unit_of(const Points& landmarks, const Surface& surface,
                                         double within, const std::string& what)
{
    // Over the diagonal: times little enough, all meet at the origin, which may lie on the surface. Set by hand: the
    // landmarks of a shape span half its diagonal and more.
    constexpr double least_spread = 0.1;
    if (landmarks.rows() < 3 || largest_distance(landmarks, surface) <= within)
        return std::nullopt;
    const double diagonal = bounding_box_diagonal(surface.points);
    const double spread = robust_spread(landmarks);
    double nearest = within;
    std::optional<std::string> said;
    for (const UnitRatio& units : unit_ratios)
        for (const bool is_larger : {true, false}) {
            const double factor = is_larger ? 1.0 / units.value : units.value;
            if (factor * spread < least_spread * diagonal)
                continue;
            const double distance = largest_distance(factor * landmarks, surface);
            if (distance > nearest)
                continue;
            nearest = distance;
            said = join("the landmarks of ", what,
                        " look as if they were in another unit than the mesh (", units.units,
                        "?): ", is_larger ? "divided by " : "times ", units.value,
                        " all of them lie on it; give them in its unit");
        }
    // Both in millimetres, as such programs have it.
    const Points turned = landmarks * Eigen::RowVector3d(-1.0, -1.0, 1.0).asDiagonal();
    if (spread >= least_spread * diagonal && largest_distance(turned, surface) <= nearest)
        said =
            join("the landmarks of ", what,
                 " look as if they were in RAS and the mesh in LPS, or the reverse: with x and y "
                 "times -1 all of them lie on it; give them in its axes");
    return said;
}

} // namespace shape::internal
