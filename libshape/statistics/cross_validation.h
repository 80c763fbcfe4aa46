// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <vector>

#include "libshape/statistics/grouping.h"

namespace shape {

/// How well groups are told apart in observations that were not learnt from.
struct CrossValidation
{
    std::vector<int> predicted; ///< N indices of groups.
    Eigen::MatrixXi confusion;  ///< G by G: row the true group, column the predicted one.
    double accuracy = 0.0;      ///< Share of observations whose group was predicted.
};

/// Predicts the group of every observation by linear discriminants of the scores of the K leading
/// principal components, both learnt without its fold.
///
/// Nothing of a fold leaks into its prediction: mean, components, covariance and group means are
/// those of the other observations. In the coordinates of all N components, which change no
/// distance, the covariance of the others is diag(variances of all) less one outer product for each
/// observation left out and one for the mean: its leading subspace is found by subspace iteration
/// with that product, to a residual of 1e-9 of the largest variance.
///
/// @param products  N by N inner products of the observations, about any origin.
/// @param groups  At least 2.
/// @param folds  At least 2, each left out once: groups_of_one(), or for instance one a subject.
/// @param modes  K >= 1.
/// @throws InvalidInput if sizes disagree, or, naming the fold, if without it a group is empty or
///     fewer than K + G observations or K components are left.
/// @throws NumericalError as discriminant_analysis().
/// Cost: an eigendecomposition of size N, then a few hundred N K^2 for each fold. Same bits for any
/// thread count.
[[nodiscard]] CrossValidation cross_validate(const Eigen::MatrixXd& products,
                                             const Grouping& groups, const Grouping& folds,
                                             int modes);

} // namespace shape
