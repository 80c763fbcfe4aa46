// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "libshape/edge_space/shape_vectors.h"
#include "libshape/embedding/energy/gauss_newton_operator.h"
#include "libshape/embedding/energy/length_dihedral_energy.h"
#include "libshape/linalg/lanes.h"
#include "libshape/linalg/single_precision_solve.h"
#include "libshape/linalg/sparse_cholesky.h"
#include "libshape/mesh/points.h"
#include "libshape/mesh/topology.h"

namespace shape::internal {

struct GrowthOptions
{
    /// How firmly dihedral angles are kept against lengths: mu of LengthDihedralEnergy; > 0.
    double smoothness = 1.0;
    /// gamma below; > 0. What is grown alike costs nothing; large: regions don't grow on their own.
    double growth_smoothness = 50.0;
    /// How much harder large strains are: c of LengthDihedralEnergy::stiffen(); >= 0. With 0.03 strains of
    /// tens of per cent count by their squares.
    double stiffness = 0.03;
    /// Whether the preconditioner knows that pulls act across a surface, not along it: a step then slides
    /// vertices as far along it as E asks. Else a step is short along the surface: it is held there as
    /// firmly as across. Of E that changes nothing.
    bool slides_freely = false;
};

/// @throws InvalidInput naming the first field that breaks its rule.
void check(const GrowthOptions& options);

/// The energy of a mesh that is pulled towards something and may grow, each vertex by its own factor:
///
///     E(x, u) = sum_e phi(l_e / (l*_e g_e) - 1) + mu (theta_e - theta*_e)^2 + gamma (u_i - u_j)^2
///               + sum_pulls w (a . (x_v - y_v) - r)^2,       g_e = exp((u_i + u_j) / 2),
///
/// l*, theta* those at rest. The first terms are a LengthDihedralEnergy; to its Gauss-Newton
/// operator this class adds the columns of u, which ride in the fourth lane of every vector, and the
/// pulls, three by three numbers a vertex. Same bits for any number of threads.
class GrowthEnergy
{
public:
    /// @throws InvalidInput if an option breaks its rule, or a length at rest is not > 0.
    GrowthEnergy(const Topology& topology, const ShapePoint& rest, const GrowthOptions& options);

    [[nodiscard]] double unit() const { return unit_; } ///< Mean edge at rest [length].

    /// Forgets all pulls; further ones are about these positions y.
    void clear_pulls(const Points& points);

    /// A pull of vertex v by `distance` along a direction.
    /// @param direction  a; its norm scales the pull.
    /// @param distance  r [length].
    /// @param weight  w [1 / unit()^2], >= 0.
    void add_pull(int vertex, const Eigen::Vector3d& direction, double distance, double weight);

    /// Factorises the preconditioner anew, for the pulls as they are. To be called before step(), and
    /// again when the pulls have become much stronger or weaker.
    void prepare();

    /// One Gauss-Newton step of this many steps of conjugate gradients, halved until E falls.
    /// @return E. Not safe to call concurrently.
    double step(Points& points, Eigen::VectorXd& growth, int linear_steps);

    /// The strains l_e / (l*_e g_e) - 1, #E.
    [[nodiscard]] Eigen::VectorXd strains(const Points& points,
                                          const Eigen::VectorXd& growth) const;

private:
    struct Gradient
    {
        Eigen::VectorXd points, growth;
    };
    double evaluate(const Eigen::VectorXd& points, const Eigen::VectorXd& growth,
                    Gradient& gradient);
    void linearise(const Eigen::VectorXd& points);
    void prepare_to_slide(const Eigen::VectorXd& weights);
    void apply(const LaneVectors& v, LaneVectors& product);
    double precondition(const LaneVectors& rhs, LaneVectors& solution);
    [[nodiscard]] Eigen::VectorXd wanted_lengths(const Eigen::VectorXd& growth) const;

    using Symmetric = Eigen::Matrix<double, 6, Eigen::Dynamic>; // xx xy xz yy yz zz a vertex

    Topology topology_;
    GrowthOptions options_;
    Eigen::VectorXd rest_lengths_;
    double unit_;
    LengthDihedralEnergy energy_;
    GaussNewtonOperator operator_;

    [[nodiscard]] SinglePrecisionSolve factor_of(const Eigen::VectorXd& weights,
                                                 const Eigen::VectorXd& added);

    std::optional<SparseCholesky>
        cholesky_; // keeps the ordering, which costs more than the numbers
    // The preconditioner: of all motions alike; or of those along the normals, along the surface, and
    // of growth.
    std::optional<SinglePrecisionSolve> preconditioner_;
    std::optional<SinglePrecisionSolve> across_, along_, growing_;
    LaneVectors normals_; // of the vertices, unit length or 0

    Eigen::VectorXd pulled_from_; // y, row by row
    Symmetric pulls_;             // sum w a a^T
    Points pull_sides_;           // sum w r a [1 / unit]
    double pull_value_ = 0.0;     // sum w r^2

    LaneVectors directions_;           // as in GaussNewtonOperator
    std::vector<float> growth_slopes_; // of the weighted strains by u at either end, negated
    Eigen::Matrix<float, 6, Eigen::Dynamic> single_pulls_;
    LaneVectors workspace_;
    LaneVectors part_, solved_; // of precondition()
};

} // namespace shape::internal
