// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>

#include "libshape/mesh/points.h"

namespace shape {

/// x -> rotation * x + translation.
struct RigidMotion
{
    Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity(); ///< Determinant +1.
    Eigen::Vector3d translation = Eigen::Vector3d::Zero();  ///< [length]

    [[nodiscard]] Points operator()(const Points& points) const;
};

/// Mean of the points [length]; there must be one.
[[nodiscard]] Eigen::RowVector3d centroid(const Points& points);

/// The rigid motion, reflections excluded, that takes `moving` closest to `fixed` in the sum of
/// squared distances (Arun, Huang, Blostein 1987).
/// @throws InvalidInput if the shapes differ or are empty.
[[nodiscard]] RigidMotion best_rigid_motion(const Points& moving, const Points& fixed);

/// The rotation R of determinant +1 that maximises trace(R^T m).
[[nodiscard]] Eigen::Matrix3d nearest_rotation(const Eigen::Matrix3d& m);

} // namespace shape
