// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <vector>

#include "libshape/edge_space/shape_vectors.h"
#include "libshape/mesh/points.h"
#include "libshape/mesh/topology.h"

namespace shape {

/// s0 of phi.
inline constexpr double stretch_onset = 0.06;

/// phi(s) = s^2 + s^4 / (s0^2 + s^2 / 8): the square of a relative edge error s,
/// stiffer by up to 9 times beyond a few per cent, so that no edge pays for all others.
struct StretchTerm
{
    double value;  ///< phi(s).
    double weight; ///< phi'(s) / (2 s).
};
[[nodiscard]] constexpr StretchTerm stretch_term(double strain)
{
    constexpr double onset = stretch_onset * stretch_onset;
    const double square = strain * strain;
    const double scale = onset + 0.125 * square;
    return {square + square * square / scale,
            1.0 + square * (2.0 * onset + 0.125 * square) / (scale * scale)};
}

/// The energy whose minimum is the closed mesh nearest to wanted lengths and dihedral angles,
///
///     E(x) = sum_e phi((l_e - l*_e) / l*_e)  +  mu sum_e (theta_e - theta*_e)^2,
///
/// differences of angles wrapped into (-pi, pi], boundary edges without the second term. (Cf.
/// Froehlich and Botsch 2011; Sassen et al. 2020, with squares in the place of phi.)
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
    /// Cost: O(#E). Works in memory that is kept: not safe to call concurrently.
    [[nodiscard]] double evaluate(const Eigen::VectorXd& points, Eigen::VectorXd& gradient);

    // Of the last evaluate():
    [[nodiscard]] const Eigen::VectorXd& lengths() const { return lengths_; }
    [[nodiscard]] const Points& normals() const { return normals_; } ///< As long as twice the area.
    [[nodiscard]] const Eigen::VectorXd& inverse_squares() const { return inverse_squares_; }

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

    // What evaluate() works in. Pages that are asked for anew at every step cost more than the work.
    Points normals_;                  // of the faces, as long as twice the area
    Eigen::VectorXd inverse_squares_; // of the normals; 0 where there is no area
    Eigen::VectorXd lengths_;
    Eigen::VectorXd energies_; // of the edges
    Eigen::VectorXd pulls_;    // dE/dl / l
    Eigen::VectorXd moments_;  // dE/dtheta
    Eigen::VectorXd lifts_;    // what angles add to the gradient at every corner, over the normal
};

} // namespace shape
