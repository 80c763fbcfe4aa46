// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>

#include "libshape/linalg/dense.h"

namespace shape {

/// Observations seen from an affine subspace.
struct SubspaceProjection
{
    RowMatrix scores;          ///< N by K, coordinates along the modes.
    Eigen::VectorXd residuals; ///< N distances to the subspace.
};

/// Projects observations onto mean + span(modes). A residual is the length of what is left after
/// the projection is taken away, so it is exact to rounding however small.
/// @param data  N by E.
/// @param mean  E.
/// @param modes  K by E, orthonormal rows.
/// @throws InvalidInput if the sizes disagree.
[[nodiscard]] SubspaceProjection project_onto_subspace(const RowMatrix& data,
                                                       const Eigen::VectorXd& mean,
                                                       const RowMatrix& modes);

} // namespace shape
