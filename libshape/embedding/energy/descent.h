// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <memory>

#include "libshape/embedding/energy/length_dihedral_energy.h"
#include "libshape/linalg/single_precision_solve.h"

namespace shape::internal {

struct DescentOptions
{
    /// The descent ends after this many linear steps in all, each one product with J^T J and one
    /// back-substitution; >= 0.
    int max_linear_steps = 120;
    /// The first Newton step takes this many linear steps; >= 2.
    int first_linear_steps = 8;
    /// It has converged once a Newton step of k linear steps lowers E by <= k * decrease_tolerance * E;
    /// >= 0.
    double decrease_tolerance = 2e-4;
    /// It has converged as well once E <= value_tolerance; >= 0.
    double value_tolerance = 0.0;
};

/// @throws InvalidInput naming the first field that breaks its rule.
void check(const DescentOptions& options);

struct Descent
{
    Eigen::VectorXd points; ///< #V by 3, row by row in one vector [length].
    double energy = 0.0;
    int linear_steps =
        0; ///< Steps of conjugate gradients: one product, one back-substitution each.
    bool converged = false;
    bool is_measured = true; ///< E was evaluated last at points.
};

/// Lowers a LengthDihedralEnergy by Gauss-Newton steps. Their linear systems are solved by conjugate
/// gradients (gauss_newton_operator.h), cut off early: at first_linear_steps first, half as many
/// again after a Newton step that did what its quadratic model said, half of them after one that did
/// not, and where three in a row promise less than a quarter of decrease_tolerance * E each.
/// (Truncated Newton method: Nocedal and Wright 2006, section 7.1.) Newton steps are halved until E
/// falls, so E never rises; but where a few edges alone rise, faces about to turn over, their vertices
/// are held for this step instead.
///
/// Keeps the memory that it works in: on large meshes fresh pages cost as much as arithmetic.
class Descender
{
public:
    /// Keeps references.
    /// @param preconditioner  Of the Laplacian weighted by 1 / l^2 (edge_laplacian.h).
    Descender(LengthDihedralEnergy& energy, const SinglePrecisionSolve& preconditioner);
    ~Descender();

    /// @throws InvalidInput if an option is out of its range.
    /// @throws NumericalError if E is not finite at the start.
    /// Not safe to call concurrently.
    [[nodiscard]] Descent descend(Eigen::VectorXd start, const DescentOptions& options = {});

private:
    struct State;
    std::unique_ptr<State> state_;
};

} // namespace shape::internal
