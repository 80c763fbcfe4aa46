// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <vector>

#include "libshape/edge_space/shape_vectors.h"
#include "libshape/mesh/points.h"
#include "libshape/mesh/topology.h"

namespace shape {

/// The energy whose minimum is the closed mesh nearest to wanted lengths and dihedral angles,
///
///     E(x) = sum_e ((l_e - l*_e) / l*_e)^2  +  mu sum_e (theta_e - theta*_e)^2,
///
/// differences of angles wrapped into (-pi, pi], boundary edges without the second term. (Cf.
/// Froehlich and Botsch 2011; Sassen et al. 2020.)
///
/// Same bits for any number of threads.
class LengthDihedralEnergy
{
public:
    /// @param smoothness  mu [1], > 0.
    /// @throws InvalidInput if target has other sizes or a length <= 0, or mu <= 0.
    LengthDihedralEnergy(const Topology& topology, const ShapePoint& target, double smoothness);

    /// Value and gradient [1/length]. A face without area adds nothing to the gradient of angles.
    /// @param points  #V by 3, row by row in one vector [length].
    /// Cost: O(#E). Safe to call concurrently.
    [[nodiscard]] double evaluate(const Eigen::VectorXd& points, Eigen::VectorXd& gradient) const;

    [[nodiscard]] const Topology& topology() const { return topology_; }
    [[nodiscard]] const ShapePoint& target() const { return target_; }
    [[nodiscard]] double smoothness() const { return smoothness_; }

private:
    Topology topology_;
    ShapePoint target_;
    double smoothness_;
    Eigen::VectorXd inverse_lengths_; // of the target
    Eigen::VectorXd sines_;           // of its dihedral angles; 0 on the boundary
    Eigen::VectorXd cosines_;         // 1 on the boundary
};

} // namespace shape
