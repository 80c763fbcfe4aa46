// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "libshape/edge_space/shape_vectors.h"
#include "libshape/mesh/points.h"
#include "libshape/mesh/topology.h"

namespace shape::internal {

inline constexpr double usual_smoothness =
    5e-3; ///< mu below [1], where nobody chooses another (docs/embedding.md).

/// q0 of bend_weights(): a triangle whose height is less than this part of its longest side is a sliver.
inline constexpr double sliver_shape = 0.2;

/// The energy whose minimum is the closed mesh nearest to wanted lengths and dihedral angles,
///
///     E(x) = sum_e phi((l_e - l*_e) / l*_e)  +  sum_e mu_e (theta_e - theta*_e)^2,
///
/// phi as in stretch_term.h, differences of angles wrapped into (-pi, pi]. mu_e is mu, 0 on the boundary, and less beside a
/// sliver: the normal of a wanted triangle says the less the flatter it is, see bend_weights(). (Cf.
/// Froehlich and Botsch 2011; Sassen et al. 2020, with squares in the place of phi, and mu_e = mu.)
///
/// Same bits for any number of threads.
class LengthDihedralEnergy
{
public:
    /// @param smoothness  mu [1], > 0.
    /// @throws InvalidInput if target has other sizes or a length <= 0, or mu <= 0.
    LengthDihedralEnergy(const Topology& topology, ShapePoint target, double smoothness);

    /// Other wanted lengths; bend_weights() stay.
    /// @param lengths  #E [length], > 0.
    void want_lengths(const Eigen::VectorXd& lengths);

    /// From now on phi(c s) / c^2 takes the place of phi(s): edges grow stiffer from stretch_onset / c on.
    /// @param stiffness  c > 0.
    void stiffen(double stiffness);
    [[nodiscard]] double stiffness() const { return stiffness_; }

    /// From now on E has another term for every face,
    ///
    ///     beta log(A*_f / (2 A_f))^2,  beta = 0.01,  where its area A_f is below half of the wanted,
    ///
    /// so that none collapses: where it would, E jumps, and minima lie on the jump. Nothing but
    /// Descender knows this term.
    void keep_areas();

    /// From now on E has another term for every vertex,
    ///
    ///     weight #E sum_v a_v |x_v - y_v|^2 / D^2,
    ///
    /// a_v being the shares of the vertices in the area of y, and D^2 = 12 sum_v a_v |y_v - centre|^2:
    /// of a box full of points that is the square of its diagonal. E is soft against what bends a mesh a
    /// little everywhere; so even a small weight keeps such a bend as it is in y, and lengths and
    /// angles hardly notice. As E itself is pose-invariant, x moves to its best fit to y on its own.
    /// @param points  y: #V by 3, row by row in one vector [length].
    /// @param weight  [1], >= 0.
    void hold_near(Eigen::VectorXd points, double weight);

    /// What this term adds at points; 0 if nothing is held.
    [[nodiscard]] double hold_energy(const Eigen::VectorXd& points) const;

    /// weight #E a_v / D^2 of every vertex [1/length^2]; empty if nothing is held.
    [[nodiscard]] const Eigen::VectorXd& hold_weights() const { return hold_weights_; }

    /// A weighted sum of the dihedral angles of interior edges, and what it is wanted to be.
    struct AngleSum
    {
        std::vector<int> edges;
        std::vector<double> factors;
        std::vector<double> aims; ///< Angles at which the sum is as wanted, one of many such [rad].
        double stiffness = 0.0;   ///< >= 0.
    };

    /// From now on E has another term for every one of them,
    ///
    ///     stiffness (sum_i factors_i (theta_i - aims_i))^2,   differences wrapped:
    ///
    /// how far a fold has turned over is prescribed, and how it does is left to E.
    /// @throws InvalidInput if an edge lies on the boundary, or sizes differ.
    void hold_sums(std::vector<AngleSum> sums);
    [[nodiscard]] const std::vector<AngleSum>& held_sums() const { return held_sums_; }

    /// A vector between two places of the mesh, and how far it is to reach.
    struct Gap
    {
        std::vector<int> vertices;
        std::vector<double>
            factors;               ///< The vector is sum_i factors_i x_i [length]; their sum is 0.
        Eigen::Vector3d direction; ///< Unit length.
        double least = 0.0;        ///< [length]
        double stiffness = 0.0;    ///< [1/length^2], >= 0.
    };

    /// From now on E has another term for every one of them,
    ///
    ///     stiffness min(0, direction . sum_i factors_i x_i - least)^2.
    ///
    /// @throws InvalidInput if vertices and factors differ in number.
    void keep_apart(std::vector<Gap> gaps);
    [[nodiscard]] const std::vector<Gap>& gaps() const { return gaps_; }

    /// What a gap lacks at points [length]; 0 if nothing.
    [[nodiscard]] static double lack(const Gap& gap, const Eigen::VectorXd& points);

    /// A face that keep_areas() acts on: r = sqrt(beta) log(A* / (2 A)), and dr by its corners.
    struct Collapse
    {
        int face;
        double residual;
        std::array<Eigen::Vector3d, 3> gradients;
    };
    /// Of the last evaluate().
    [[nodiscard]] const std::vector<Collapse>& collapses() const { return collapses_; }

    /// E alone.
    /// @param points  #V by 3, row by row in one vector [length].
    /// Cost: O(#E). Works in memory that is kept: not safe to call concurrently.
    [[nodiscard]] double evaluate(const Eigen::VectorXd& points);

    /// Of E at the points of the last evaluate() [1/length]. A face without area adds nothing to the gradient of
    /// angles. Cost: half of evaluate().
    void find_gradient(const Eigen::VectorXd& points, Eigen::VectorXd& gradient);

    /// Both.
    [[nodiscard]] double evaluate(const Eigen::VectorXd& points, Eigen::VectorXd& gradient);

    // Of the last evaluate():
    [[nodiscard]] const Eigen::VectorXd& lengths() const { return lengths_; }
    [[nodiscard]] const Eigen::VectorXd& edge_energies() const { return energies_; }
    [[nodiscard]] const Points& normals() const { return normals_; } ///< As long as twice the area.
    [[nodiscard]] const Eigen::VectorXd& inverse_squares() const { return inverse_squares_; }
    /// theta - theta* of an edge, wrapped; 0 on the boundary and beside a face without area [rad]. Not while sums
    /// are held.
    [[nodiscard]] double bend(int edge) const
    {
        return bend_weights_[edge] > 0.0 ? 0.5 * moments_[edge] / bend_weights_[edge] : 0.0;
    }

    [[nodiscard]] const Topology& topology() const { return topology_; }
    [[nodiscard]] const ShapePoint& target() const { return target_; }

    /// mu_e, #E: mu min(1, (q / q0)^2) but not below mu / 100, where q is the height of the flatter of
    /// the two wanted triangles over its longest side, divided by this side.
    [[nodiscard]] const Eigen::VectorXd& bend_weights() const { return bend_weights_; }

    /// Of the wanted angles; of 0 on the boundary.
    [[nodiscard]] const Eigen::VectorXd& sines() const { return sines_; }
    [[nodiscard]] const Eigen::VectorXd& cosines() const { return cosines_; }

private:
    void measure_edges(const Eigen::VectorXd& points); ///< After the normals.
    void add_collapses(const Eigen::VectorXd& points);
    [[nodiscard]] double add_sums();
    [[nodiscard]] double gap_energy(const Eigen::VectorXd& points) const;
    void add_gaps(const Eigen::VectorXd& points, Eigen::VectorXd& gradient) const;
    void add_hold(const Eigen::VectorXd& points, Eigen::VectorXd& gradient) const;

    Topology topology_;
    ShapePoint target_;
    Eigen::VectorXd bend_weights_;
    Eigen::VectorXd inverse_lengths_; // of the target
    Eigen::VectorXd sines_;           // of its dihedral angles; 0 on the boundary
    Eigen::VectorXd cosines_;         // 1 on the boundary

    double stiffness_ = 1.0;
    bool areas_kept_ = false;
    Eigen::VectorXd least_squares_; // of normals of faces with half of the wanted area

    std::vector<AngleSum> held_sums_;
    std::vector<Gap> gaps_;
    Eigen::VectorXd held_points_;
    Eigen::VectorXd hold_weights_;

    // What they work in. Pages that are asked for anew at every step cost more than the work.
    Points normals_;                  // of the faces, as long as twice the area
    Eigen::VectorXd inverse_squares_; // of the normals, bounded; see face_normals()
    Eigen::VectorXd lengths_;
    Eigen::VectorXd energies_; // of the edges
    Eigen::VectorXd pulls_;    // dE/dl / l
    Eigen::VectorXd moments_;  // dE/dtheta
    std::vector<Collapse> collapses_;
    Eigen::VectorXd lifts_; // what angles add to the gradient at every corner, over the normal
};

} // namespace shape::internal
