// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <limits>

#include "libshape/statistics/grouping.h"

namespace shape {

struct PermutationOptions
{
    /// The statistic is compared with this many permutations; >= 0. The smallest p-value is
    /// 1 / (permutations + 1), or LinearModelTest::smallest_p if that is larger.
    int permutations = 999;
    /// All permutations depend on this.
    std::uint64_t seed = 1;
};

/// @throws InvalidInput naming the first field that breaks its rule.
void check(const PermutationOptions& options);

/// How much of the variation of N points some columns explain, and whether that is chance. Of what was not tested, all
/// is NaN, and the counts are 0.
struct LinearModelTest
{
    static constexpr double none = std::numeric_limits<double>::quiet_NaN();

    double sum_of_squares = none;          ///< Explained by the tested columns, beyond all others.
    double residual_sum_of_squares = none; ///< Explained by nothing.
    double total_sum_of_squares = none;    ///< About the mean of all points.
    int degrees_of_freedom = 0;            ///< Rank of the tested columns beyond all others.
    int residual_degrees_of_freedom = 0;
    double f = none;         ///< Ratio of the mean squares; infinite if nothing is left over.
    double r_squared = none; ///< sum_of_squares / total_sum_of_squares.
    /// (1 + #{permuted F >= F}) / (1 + permutations), or smallest_p if that is larger; NaN without permutations.
    double p_value = none;
    int permutations = 0;
    /// What p_value tends to, with ever more permutations, if F is the largest that the design allows: 1 over the
    /// number of permutations whose F may differ. 0.1 of three points against three: there are 20, and each has the F
    /// of that which exchanges the groups. Permutations that move no row of the columns about their means in the blocks
    /// are one, and so are those that the design cannot tell apart (internal::design_symmetries()): groups of a size
    /// that change their names, a covariate whose values are their own mirror image. Columns that are constant in each
    /// block change nothing. 0 if there are more than 1e308.
    double smallest_p = none;
};

/// Tests columns of a linear model of points by permutation: the Procrustes ANOVA of morphometrics
/// (Goodall 1991; RRPP, Collyer et al. 2015) and the PERMANOVA of distances (Anderson 2001;
/// McArdle & Anderson 2001) are special cases.
///
/// The model is points = blocks + nuisance + tested + residual, least squares in each coordinate.
/// With G the inner products, R the projection away from blocks and nuisance, and Q an orthonormal
/// basis of R tested, the tested columns explain tr(Q^T G Q) of tr(R G R). Residuals of the model
/// without the tested columns are permuted within the blocks (Freedman & Lane 1983): with no
/// nuisance but the blocks that is the same as permuting the rows of the tested columns, and the
/// test is exact if they are exchangeable within the blocks.
///
/// @param products  N by N inner products of the points, about any origin (inner_products.h).
/// @param tested  N by at least 1: indicators of groups, covariates.
/// @param nuisance  N by any number, also 0. The constant is in the model anyway.
/// @param blocks  Each has an effect of its own; one_group() if there are none.
/// @throws InvalidInput if sizes disagree, an entry is not finite, the tested columns say nothing
///     beyond the others, no degree of freedom is left, or the points do not vary within the blocks.
/// Cost: N^2 multiplications for each permutation and column. Same bits for any thread count.
[[nodiscard]] LinearModelTest test_linear_model(const Eigen::MatrixXd& products,
                                                const Eigen::MatrixXd& tested,
                                                const Eigen::MatrixXd& nuisance,
                                                const Grouping& blocks,
                                                const PermutationOptions& options = {});

} // namespace shape
