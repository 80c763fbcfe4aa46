// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>

namespace shape::internal {

/// Leading eigenpairs of a symmetric matrix.
struct Eigenpairs
{
    Eigen::VectorXd values;  ///< k, descending.
    Eigen::MatrixXd vectors; ///< #rows by k, orthonormal columns; the sign is arbitrary but fixed.
};

/// The k largest eigenvalues of a dense symmetric matrix and their vectors: Spectra's Lanczos
/// method from a fixed start, Eigen's full decomposition where k is a large part of the size or
/// where the Lanczos run does not pass its check (it can miss copies of a multiple eigenvalue).
///
/// @param matrix  Symmetric, only its lower triangle is read; finite.
/// @param count  k in [1, #rows].
/// @throws InvalidInput if a rule above is broken.
/// @throws NumericalError if the full decomposition fails.
/// Accuracy: a vector solves A v = lambda v to 1e-11 times the largest |lambda| returned.
[[nodiscard]] Eigenpairs largest_eigenpairs(const Eigen::MatrixXd& matrix, int count);

} // namespace shape::internal
