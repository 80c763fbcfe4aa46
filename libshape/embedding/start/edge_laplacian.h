// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <optional>

#include "libshape/embedding/start/face_layout.h"
#include "libshape/linalg/single_precision_solve.h"
#include "libshape/linalg/sparse_cholesky.h"
#include "libshape/mesh/points.h"
#include "libshape/mesh/topology.h"

namespace shape::internal {

/// The Laplacian of a mesh whose edges weigh 1 / l^2, once for every face they have, and its
/// factorisation. Lengths below 1e-3 of the mean count as that. Relative errors of edges count alike
/// in it, as they do in what is minimised.
class EdgeLaplacian
{
public:
    /// @param lengths  #E [length], > 0.
    /// @throws NumericalError if the factorisation breaks down all the same.
    /// Cost: one sparse Cholesky factorisation of size #V.
    EdgeLaplacian(const Topology& topology, const Eigen::VectorXd& lengths);

    /// With a factor in single precision found before: single_precision() of an EdgeLaplacian of the same arguments.
    /// @throws InvalidInput if it has another size.
    EdgeLaplacian(const Topology& topology, const Eigen::VectorXd& lengths,
                  SinglePrecisionSolve factor);

    /// Solves for all three columns at once, in double precision: with a factor found before, by conjugate
    /// gradients, which it brings to their end in a few steps. A translation is held by a little weight
    /// at vertex 0.
    [[nodiscard]] Points solve(const Points& rhs) const;

    /// The factor, for preconditioning.
    [[nodiscard]] const SinglePrecisionSolve& single_precision() const { return factor_; }

    /// Positions whose edges are nearest to what the faces want: their sides as laid out, turned by
    /// their frames.
    /// @param frames  #F.
    [[nodiscard]] Points positions(const FaceLayout& layout, const Rotations& frames) const;

    /// What positions() in single precision works in, kept by who calls it again and again.
    struct Memory
    {
        LaneVectors pulls, rhs, solution, workspace;
    };

    /// The same about as exactly as float allows, several times faster.
    /// @param solve  What single_precision() gave.
    /// @param points  Overwritten.
    void positions(const FaceLayout& layout, const Rotations& frames,
                   const SinglePrecisionSolve& solve, Memory& memory, Points& points) const;

    [[nodiscard]] const Eigen::VectorXd& weights() const { return weights_; } ///< #E, 1 / l^2.

private:
    [[nodiscard]] Points solve_by_conjugate_gradients(const Points& rhs) const;

    Topology topology_;
    Eigen::VectorXd weights_;
    SparseMatrix matrix_;                 // its lower triangle
    std::optional<SparseCholesky> exact_; // unless a factor was given
    SinglePrecisionSolve factor_;
};

} // namespace shape::internal
