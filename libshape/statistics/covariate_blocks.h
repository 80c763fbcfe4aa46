// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>

#include "libshape/statistics/group_comparison.h"
#include "libshape/statistics/grouping.h"
#include "libshape/statistics/linear_model.h"

namespace shape {

/// How covariates lie to blocks: nested if each is the same for all members of every block (the age
/// of a person who was scanned several times), crossed if each differs within some block, or if there
/// is but one block.
/// @param covariates  N by C.
/// @throws InvalidInput naming both columns if some are nested and some crossed: they ask different
///     questions, each of a test of its own; or if the sizes disagree.
[[nodiscard]] BlockDesign block_design(const Eigen::MatrixXd& covariates, const Grouping& blocks);

/// Which observations count together, by their mean. Nested: those of a block. Crossed: those of a block that have the
/// same covariates, such as scans of one visit; they say how well it was measured, not how much blocks differ. In one
/// block each counts by itself.
/// @throws InvalidInput as block_design().
[[nodiscard]] Grouping covariate_rows(const Eigen::MatrixXd& covariates, const Grouping& blocks);

/// Weights that make every block one observation, its mean: N by B, 1 / size of the block for its
/// members, else 0.
[[nodiscard]] Eigen::MatrixXd mean_weights(const Grouping& blocks);

/// What a test of covariates by permutation may exchange.
struct ExchangeableRows
{
    BlockDesign design = BlockDesign::Crossed;
    Eigen::MatrixXd products;   ///< Inner products of the rows.
    Eigen::MatrixXd covariates; ///< Their covariates.
    Grouping blocks;            ///< Within which they are exchanged; one if nested.
};

/// The means of covariate_rows(): nested, of the blocks, freely; repeated measurements of one specimen are not
/// independent observations.
/// @param products  N by N inner products of the observations.
/// @throws InvalidInput as block_design().
[[nodiscard]] ExchangeableRows exchangeable_rows(const Eigen::MatrixXd& products,
                                                 const Eigen::MatrixXd& covariates,
                                                 const Grouping& blocks);

/// Whether slopes within blocks are tested against how much they differ between blocks (internal::test_slopes()):
/// crossed, if several blocks have several rows. In blocks of two rows exchanging these reverses the slope, so that
/// test_linear_model() does the same.
[[nodiscard]] bool compares_slopes(const ExchangeableRows& rows);

/// Tests some covariates of such rows beyond others: by test_linear_model(), but for compares_slopes().
/// @param tested, nuisance  Columns of rows.covariates.
/// @throws InvalidInput as those.
[[nodiscard]] LinearModelTest test_covariates(const ExchangeableRows& rows,
                                              const Eigen::MatrixXd& tested,
                                              const Eigen::MatrixXd& nuisance,
                                              const PermutationOptions& options = {});

} // namespace shape
