// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>

#include "libshape/statistics/group_comparison.h"
#include "libshape/statistics/grouping.h"

namespace shape {

/// How covariates lie to blocks: nested if each is the same for all members of every block (the age
/// of a person who was scanned several times), crossed if each differs within some block, or if there
/// is but one block.
/// @param covariates  N by C.
/// @throws InvalidInput naming both columns if some are nested and some crossed: they ask different
///     questions, each of a test of its own; or if the sizes disagree.
[[nodiscard]] BlockDesign block_design(const Eigen::MatrixXd& covariates, const Grouping& blocks);

/// Weights that make every block one observation, its mean: N by B, 1 / size of the block for its
/// members, else 0.
[[nodiscard]] Eigen::MatrixXd mean_weights(const Grouping& blocks);

/// What a test of covariates by permutation may exchange.
struct ExchangeableRows
{
    BlockDesign design = BlockDesign::Crossed;
    Eigen::MatrixXd products;   ///< Inner products of the observations, or of the means of blocks.
    Eigen::MatrixXd covariates; ///< Their covariates.
    Grouping blocks;            ///< Within which they are exchanged; one if nested.
};

/// Crossed: the observations, within the blocks. Nested: the means of the blocks, freely; repeated
/// measurements of one specimen are not independent observations.
/// @param products  N by N inner products of the observations.
/// @throws InvalidInput as block_design().
[[nodiscard]] ExchangeableRows exchangeable_rows(const Eigen::MatrixXd& products,
                                                 const Eigen::MatrixXd& covariates,
                                                 const Grouping& blocks);

} // namespace shape
