// SPDX-License-Identifier: MIT

#pragma once

#include <vector>

#include "libshape/mesh/points.h"
#include "libshape/registration/closest_points.h"
#include "libshape/registration/rims.h"

namespace shape::internal {

/// A triangle soup with all that is asked of it again and again.
struct Surface
{
    Points points;
    Faces faces;
    Points normals;           ///< Of the vertices, unit length; 0 where faces cancel.
    std::vector<char> on_rim; ///< Per vertex.
    Rims rims;
    ClosestPoints tree;

    Surface(Points vertices, Faces triangles);

    /// Whether a nearest point lies on the rim: then the surface may go on beyond it, unseen.
    [[nodiscard]] bool ends_at(const SurfacePoint& point) const;

    /// The normal there, unit length or 0.
    [[nodiscard]] Eigen::Vector3d normal_at(const SurfacePoint& point) const;
};

/// The faces of a scan, each turned over where a clear majority of its patch (faces joined by edges that both run
/// through in opposite directions) faces away from the nearest faces of `reference`.
/// @return Faces, and how many were turned over.
[[nodiscard]] std::pair<Faces, int> oriented_like(const Points& points, const Faces& faces,
                                                  const Surface& reference);

} // namespace shape::internal
