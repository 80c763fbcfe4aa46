// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>

#include "libshape/statistics/group_comparison.h"
#include "libshape/statistics/grouping.h"
#include "libshape/statistics/regression.h"

// What a regression within blocks takes of the covariates alone, without the observations.

namespace shape::internal {

/// Covariates and, behind them, what tells the blocks apart.
[[nodiscard]] Eigen::MatrixXd with_blocks(const Eigen::MatrixXd& covariates,
                                          const Grouping& blocks);

/// What means of observations (covariate_rows()) are regressed on: nested, covariates alone.
/// @param covariates  Of the rows.
/// @param blocks, rows  Of the observations.
[[nodiscard]] Eigen::MatrixXd columns_of_rows(const Eigen::MatrixXd& covariates,
                                              const Grouping& blocks, const Grouping& rows,
                                              BlockDesign design);

/// The first covariates alone.
[[nodiscard]] Regression head(Regression regression, Eigen::Index count);

struct EffectWeights
{
    BlockDesign design = BlockDesign::Crossed;
    Regression
        regression; ///< Means of the covariates, and weights, N by C; nothing of observations.
    Eigen::VectorXd shares; ///< N: of the observations in the mean; their sum is 1.
    Eigen::MatrixXd
        means; ///< N by R, mean_weights() of covariate_rows(); N by 0 if each observation is one.
    Eigen::MatrixXd
        centred;       ///< What is regressed on, blocks too if they are crossed, about its mean.
    RowMatrix weights; ///< As many rows; of all slopes.
};

/// @throws InvalidInput as block_design() and regress().
[[nodiscard]] EffectWeights effect_weights(const Eigen::MatrixXd& covariates,
                                           const Grouping& blocks);

/// r_squared of regress(), from N by N inner products of the observations about any origin.
[[nodiscard]] double explained_share(const Eigen::MatrixXd& products, const EffectWeights& weights);

} // namespace shape::internal
