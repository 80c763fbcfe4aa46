// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>

#include "libshape/linalg/dense.h"

namespace shape {

/// Least squares line (plane, ...) of N observations of E variables on C covariates: at the
/// covariates c it is mean + sum_k (c_k - covariate_means[k]) slopes.row(k).
struct Regression
{
    Eigen::VectorXd mean;            ///< E.
    Eigen::VectorXd covariate_means; ///< C.
    RowMatrix slopes;                ///< C by E; per unit of the covariate.
    RowMatrix weights;               ///< N by C, columns of sum 0: slopes = weights^T data.
    double r_squared = 0.0;          ///< Share of the sum of squares of the data, in [0, 1].
};

/// Fits data = mean + (covariates - covariate means) slopes by least squares.
/// The weights give the slopes of any other quantity of the same observations: weights^T companion.
/// What a covariate does to an observation is taken away by data.row(i) - (c_i - reference) slope.
/// Whether it does anything: test_linear_model().
///
/// @param data  N by E, finite; one observation a row.
/// @param covariates  N by C, C >= 1.
/// @throws InvalidInput if sizes disagree, an entry is not finite, N < C + 2, the sum of a covariate's squares overflows
///     or underflows, or a covariate is a combination of the others and the constant (within 1e-9 of its standard
///     deviation).
/// Cost: 4 N E C multiplications.
[[nodiscard]] Regression regress(const RowMatrix& data, const Eigen::MatrixXd& covariates);

/// Where each observation lies along one slope, in units of the covariate: its projection onto the
/// slope, (x - mean) . slope / |slope|^2 + covariate mean (the regression score of Drake &
/// Klingenberg 2008, scaled). N entries.
/// @param covariate  Index in [0, C), of a slope that is not 0.
/// @throws InvalidInput if a rule is broken.
[[nodiscard]] Eigen::VectorXd regression_scores(const Regression& regression, const RowMatrix& data,
                                                int covariate);

} // namespace shape
