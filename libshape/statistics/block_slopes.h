// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>

#include "libshape/statistics/grouping.h"
#include "libshape/statistics/linear_model.h"

namespace shape::internal {

/// Tests slopes within blocks, such as growth within people, against how much these differ between blocks.
/// test_linear_model() asks whether any block has a slope: where each has one of its own and their mean is 0, it finds
/// that nearly always.
///
/// In the notation of linear_model.h, Q^T R x is the sum of what each block adds to it, u_b. If slopes are as likely
/// one way as the other, so are the u_b, and any of them may be reversed. The statistic is how much of R x the columns
/// R S Q explain, S being the signs of the blocks (sign-flipping of scores: Hemerik, Goeman and Finos 2020; with
/// nuisance, as there, to the first order). F compares with the differences of slopes, tr(u_b^T (w_b^T w_b)^-1 u_b)
/// summed over the blocks less what is explained, w_b being the weights of the observations in u_b: where every block
/// has two rows, the F and the permutations of test_linear_model(). Sums of squares and R^2 are those of that test,
/// smallest_p is 2 to the power of 1 - the number of blocks in which the tested columns vary.
///
/// @param products, tested, nuisance, blocks, options  As test_linear_model() takes them.
/// @throws InvalidInput as that does; or if the columns vary in one block only.
/// Cost: (B K)^2 multiplications for each permutation, of B blocks and K columns. Same bits for any thread count.
[[nodiscard]] LinearModelTest test_slopes(const Eigen::MatrixXd& products,
                                          const Eigen::MatrixXd& tested,
                                          const Eigen::MatrixXd& nuisance, const Grouping& blocks,
                                          const PermutationOptions& options);

} // namespace shape::internal
