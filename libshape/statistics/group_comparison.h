// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <vector>

#include "libshape/statistics/grouping.h"
#include "libshape/statistics/linear_model.h"

namespace shape {

/// How blocks and groups lie to each other.
enum class BlockDesign
{
    Crossed, ///< Blocks have members of several groups: they are compared within the blocks.
    Nested,  ///< Every block lies in one group: the means of the blocks are compared.
};

/// Crossed if any block has members of several groups.
/// @throws InvalidInput if the sizes disagree.
[[nodiscard]] BlockDesign block_design(const Grouping& groups, const Grouping& blocks);

/// Two groups against each other.
struct PairComparison
{
    int first = 0; ///< Indices of the groups, first < second.
    int second = 0;
    double distance = 0.0; ///< Between the means of the groups; NaN if it is not determined.
    LinearModelTest test;  ///< These two groups alone are compared.
    /// For all pairs that were tested (Holm 1979); NaN of another.
    double adjusted_p = LinearModelTest::none;
};

/// Whether groups differ, all at once and two at a time.
struct GroupComparison
{
    BlockDesign design = BlockDesign::Nested;
    LinearModelTest overall;
    std::vector<PairComparison> pairs; ///< (0, 1), (0, 2), ..., (1, 2), ...
    int left_out =
        0; ///< Observations of blocks of one group, which say nothing in a crossed design.
};

/// Compares the means of groups by permutation (linear_model.h).
///
/// With blocks of one observation each, all observations are exchangeable. Blocks that contain
/// several groups, such as subjects in several states, have an effect of their own, and labels are
/// permuted within them. Blocks that each lie in one group, such as repeated scans of subjects of
/// two sexes, are exchanged as a whole: the mean of a block counts as one observation.
///
/// A pair uses the observations of its two groups, and of them only blocks that have both if the
/// design of the pair is crossed.
///
/// Means, and so distances, are those that the test is of: nested, of the means of the blocks; crossed, of blocks
/// that have members of several groups, each once, so that a distance is that of the mean difference within the
/// blocks (of blocks that lack some of the groups, by least squares); with covariates, at the means of these, by the
/// slopes common to all groups. What needs the slope of a covariate that varies between groups alone (crossed:
/// between blocks alone) is not determined.
///
/// @param products  N by N inner products of the observations.
/// @param groups  At least 2.
/// @param blocks  groups_of_one() if there are none.
/// @param covariates  N by any number, also 0: nuisance of all tests.
/// @throws InvalidInput if there are fewer than 2 groups, no more observations (blocks, if nested)
///     than groups, if those of blocks that have several groups are too few, or as test_linear_model(), naming the
///     pair. Where a pair leaves no degree of freedom, such as two groups of one observation, it is not tested.
[[nodiscard]] GroupComparison compare_groups(const Eigen::MatrixXd& products,
                                             const Grouping& groups, const Grouping& blocks,
                                             const Eigen::MatrixXd& covariates,
                                             const PermutationOptions& options = {});

/// Probabilities adjusted for their number by the step-down method of Holm (1979). NaN stays NaN and is not counted.
[[nodiscard]] Eigen::VectorXd holm_adjusted(const Eigen::VectorXd& p_values);

} // namespace shape
