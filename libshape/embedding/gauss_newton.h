// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "libshape/embedding/length_dihedral_energy.h"
#include "libshape/linalg/sparse_cholesky.h"

namespace shape {

struct GaussNewtonOptions
{
    int max_iterations = 20; ///< Factorisations at most; >= 0.
    /// Converged once a step lowers E by <= decrease_tolerance * E.
    double decrease_tolerance = 1e-6;
};

struct GaussNewtonResult
{
    Eigen::VectorXd points; ///< All vertices, row by row [length].
    double value = 0.0;     ///< Terms of E that the moved vertices take part in.
    int iterations = 0;
    bool converged = false;
};

/// Levenberg's damped Gauss-Newton method on a LengthDihedralEnergy, for some vertices while the
/// others are held. The pattern of the normal matrix is found once.
class GaussNewton
{
public:
    /// @param vertices  To be moved; distinct, not empty. All of them may be named: then the rigid
    ///     motion is held by the damping, which never vanishes.
    GaussNewton(const Topology& topology, std::vector<int> vertices);

    /// @param points  Row by row [length].
    /// @throws NumericalError if E is not finite at the start.
    /// Cost: a sparse Cholesky factorisation of size 3 #vertices an iteration.
    [[nodiscard]] GaussNewtonResult minimize(const LengthDihedralEnergy& energy,
                                             Eigen::VectorXd points,
                                             const GaussNewtonOptions& options = {}) const;

    [[nodiscard]] const std::vector<int>& vertices() const { return vertices_; }

    /// Edges of the terms that the vertices take part in, ascending.
    [[nodiscard]] const std::vector<int>& edges() const { return edges_; }

private:
    struct Linearisation;
    double evaluate(const LengthDihedralEnergy& energy, const Eigen::VectorXd& points,
                    Linearisation* linearisation) const;

    Topology topology_;
    std::vector<int> vertices_;
    std::vector<int> edges_;
    std::vector<std::array<int, 4>> wedges_; // rows of the system, -1 if held: ends, left, right
    SparseMatrix pattern_;                   // lower block triangle, all values 0
    std::vector<int> block_begin_;           // first block of a block column, and their rows
    std::vector<int> block_row_;
};

} // namespace shape
