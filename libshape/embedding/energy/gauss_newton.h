// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <vector>

#include "libshape/embedding/energy/graded_unknowns.h"
#include "libshape/embedding/energy/length_dihedral_energy.h"
#include "libshape/linalg/sparse_cholesky.h"

namespace shape::internal {

struct GaussNewtonOptions
{
    /// It ends after this many factorisations; >= 0.
    int max_iterations = 20;
    /// It has converged once a step lowers E by <= decrease_tolerance * E; >= 0.
    double decrease_tolerance = 1e-6;
    /// phi(c s) / c^2 takes the place of phi(s) in E: edges grow stiffer from stretch_onset / c on; c > 0.
    double stiffness = 1.0;
};

/// @throws InvalidInput naming the first field that breaks its rule.
void check(const GaussNewtonOptions& options);

struct GaussNewtonResult
{
    Eigen::VectorXd points; ///< All vertices, row by row [length].
    double value = 0.0;     ///< Terms of E that the moved vertices take part in.
    int iterations = 0;
    bool converged = false;
    double last_step =
        0.0; ///< The part of the last step that was taken, in [0, 1]; 0: none lowers E.
};

/// Levenberg's damped Gauss-Newton method on a LengthDihedralEnergy, for some vertices while the
/// others are held. The pattern of the normal matrix is found once.
///
/// Steps are curved. An edge that a straight step d turns by an angle phi grows by phi^2 / 2, and E notices
/// lengths more than bends; so straight steps end as soon as any edge has turned by some degrees. The
/// second order of the path, x - t d - t^2 a / 2, takes that back: a is the Gauss-Newton step for how the
/// residuals curve along d (geodesic acceleration, Transtrum and Sethna 2012). It costs a
/// back-substitution with the factor that is there.
class GaussNewton
{
public:
    /// Moves the vertices that the unknowns move. Those may leave a rigid motion free: the damping, which
    /// never vanishes, holds it.
    GaussNewton(const Topology& topology, const GradedUnknowns& unknowns);

    /// @param points  Row by row [length].
    /// @param kept  A factor of an earlier call, or none: its analysis is used and it is left for
    ///     the next call. Null for a factor of this call alone.
    /// @throws InvalidInput if an option breaks its rule.
    /// @throws NumericalError if E is not finite at the start.
    /// Cost: a sparse Cholesky factorisation of size 3 #vertices an iteration.
    [[nodiscard]] GaussNewtonResult minimize(const LengthDihedralEnergy& energy,
                                             Eigen::VectorXd points,
                                             const GaussNewtonOptions& options = {},
                                             std::optional<SparseCholesky>* kept = nullptr) const;

private:
    /// An unknown translation that moves some of the vertices of a hinge, not all of them.
    struct Part
    {
        int row;
        unsigned moved; // bit a: vertex a of the hinge
    };
    struct Residuals;
    struct Slopes;
    void find_pattern(const std::vector<std::vector<int>>& rows);
    [[nodiscard]] Residuals evaluate(const LengthDihedralEnergy& energy,
                                     const Eigen::VectorXd& points, double stiffness,
                                     Slopes* slopes) const;
    [[nodiscard]] Eigen::VectorXd forces(const Slopes& slopes, const Residuals& residuals) const;
    void fill(const Slopes& slopes, SparseMatrix& matrix) const;
    [[nodiscard]] Eigen::VectorXd moved(Eigen::VectorXd points, double scale,
                                        const Eigen::VectorXd& step) const;

    Topology topology_;
    std::vector<int> vertices_;
    std::vector<int> edges_;
    std::vector<int> carried_begin_; // vertices that move with vertices_[i], and itself
    std::vector<int> carried_;
    std::vector<int> part_begin_; // first part of the hinge of edges_[i]
    std::vector<Part> parts_;
    SparseMatrix pattern_;         // lower block triangle, all values 0
    std::vector<int> block_begin_; // first block of a block column, and their rows
    std::vector<int> block_row_;
    std::vector<int> pair_value_; // first value of every two parts of a hinge, by their lower one
};

} // namespace shape::internal
