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
    int modes = 0;              ///< K.
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
/// @throws InvalidInput if sizes disagree, all observations are equal, or, naming the fold, if without it a group is empty or
///     fewer than K + G observations or K components (of more than 1e-12 of the largest variance of all) are left.
/// @throws NumericalError as discriminant_analysis().
/// Cost: an eigendecomposition of size N, then a few hundred N K^2 for each fold. Same bits for any
/// thread count.
[[nodiscard]] CrossValidation cross_validate(const Eigen::MatrixXd& products,
                                             const Grouping& groups, const Grouping& folds,
                                             int modes);

/// The same with as many modes, at most `most`, as every fold leaves to learn from: observations less groups,
/// components, and of these those before the first in which the pooled covariance of the groups is singular.
/// @throws InvalidInput as cross_validate() with one mode; NumericalError, naming a fold, if in its first component
///     already no group varies.
/// Cost: as cross_validate(), of few components twice as much.
[[nodiscard]] CrossValidation cross_validate_up_to(const Eigen::MatrixXd& products,
                                                   const Grouping& groups, const Grouping& folds,
                                                   int most);

} // namespace shape
