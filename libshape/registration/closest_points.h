// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <limits>
#include <memory>

#include "libshape/mesh/points.h"

namespace shape::internal {

/// A point of a triangle soup.
struct SurfacePoint
{
    int face = -1;                                             ///< -1: there is none.
    Eigen::Vector3d barycentric = Eigen::Vector3d::Zero();     ///< Of its corners; >= 0, sum 1.
    Eigen::Vector3d position = Eigen::Vector3d::Zero();        ///< [length]
    double distance = std::numeric_limits<double>::infinity(); ///< [length]
};

/// What a nearest point must be besides near.
struct NearestRule
{
    /// Points farther than this do not count [length]; > 0.
    double within = std::numeric_limits<double>::infinity();
    /// The normal at the point that is asked about, unit length; 0: normals do not matter.
    Eigen::Vector3d normal = Eigen::Vector3d::Zero();
    /// Faces count whose unit normal n has n . normal >= least_cosine.
    double least_cosine = -2.0;
    /// The point minimises distance^2 + normal_weight^2 |n - normal|^2 [length]; >= 0.
    double normal_weight = 0.0;
    /// A face to look at first, or -1. A good guess shortens the search and changes nothing else.
    int guess = -1;
};

/// Nearest points of a triangle soup, exactly: no topology is asked for, faces may overlap or have no
/// area. A k-d tree (nanoflann) of points spread over the faces so densely that every point of a face
/// is within cover() of one; a search looks that much farther than the best point found so far.
class ClosestPoints
{
public:
    /// @param points  Finite.
    /// @param faces  At least one; indices in range.
    /// @throws InvalidInput if a rule is broken.
    /// Cost: O(#F log #F), for 1e6 faces about 100 MB.
    ClosestPoints(const Points& points, const Faces& faces);

    /// With other unit vectors in the place of normals, #F by 3: curves are faces a b b.
    ClosestPoints(const Points& points, const Faces& faces, const Points& normals);
    ~ClosestPoints();
    ClosestPoints(ClosestPoints&&) noexcept;
    ClosestPoints& operator=(ClosestPoints&&) noexcept;

    /// Of points that are equally near, that of the lowest face. Safe to call concurrently.
    [[nodiscard]] SurfacePoint nearest(const Eigen::Vector3d& point,
                                       const NearestRule& rule = {}) const;

    /// A point of a face at most cover() farther away than the nearest; many times faster far from the faces.
    /// Safe to call concurrently.
    [[nodiscard]] Eigen::Vector3d near_point(const Eigen::Vector3d& point) const;

    [[nodiscard]] double cover() const; ///< [length]

private:
    struct Tree;
    std::unique_ptr<Tree> tree_;
};

} // namespace shape::internal
