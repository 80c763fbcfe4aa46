// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>

#include "libshape/linalg/dense.h"

namespace shape {

/// Mean and principal modes of N observations of E variables.
struct PrincipalComponents
{
    Eigen::VectorXd mean;        ///< E.
    RowMatrix modes;             ///< K by E, orthonormal rows.
    Eigen::VectorXd variances;   ///< K, descending, > 0; divisor N - 1.
    double total_variance = 0.0; ///< The sum over all modes, kept or not.
    RowMatrix scores;            ///< N by K, coordinates along the modes: (data - mean) modes^T.
    RowMatrix weights;           ///< N by K, columns of sum 0: modes = weights^T data.
};

struct PrincipalComponentsOptions
{
    /// This many modes are kept, K in [1, N - 1]; 0: as few as have the share `variance`.
    int modes = 0;
    /// The modes kept have at least this share of the total variance; in (0, 1], and 1 unless `modes`
    /// is 0.
    double variance = 1.0;
};

/// @throws InvalidInput naming the first field that breaks its rule.
void check(const PrincipalComponentsOptions& options);

/// Principal component analysis through the N by N Gram matrix G = X X^T of the centred data X
/// ("method of snapshots", Sirovich 1987); never an E by E matrix.
///
/// With an eigenpair (g, u) of G the mode is X^T u / sqrt(g) and its variance g / (N - 1). The modes
/// are then orthonormalised, rotated until their scores are uncorrelated (one-sided Jacobi), and
/// the variances measured on the scores, so that modes of little variance are as good as those of
/// much. Modes of a variance below 1e-12 times the largest are rounding and left out: K can be
/// less than what was asked for.
/// The sign of a mode makes its entry of largest magnitude positive (the first of equals).
///
/// @param data  N by E, finite; one observation a row. Centred in place: moved in, it is not copied.
/// @throws InvalidInput if N < 2, E = 0, an entry is not finite, an option is out of its range, or
///     all observations are equal: sum_i |x_i - mean|^2 <= 1e-24 sum_i |x_i|^2.
/// Cost: N^2 E / 2 multiplications for G, about 2 (N + K) K E for the rest. Same bits for any thread count.
[[nodiscard]] PrincipalComponents principal_components(
    RowMatrix data, const PrincipalComponentsOptions& options = {});

/// What each mode does, per unit of score, to another quantity of the same observations: the
/// combination weights^T companion, K by columns of `companion`.
/// @throws InvalidInput if companion does not have N rows.
[[nodiscard]] RowMatrix companion_modes(const PrincipalComponents& components, RowMatrix companion);

} // namespace shape
