// SPDX-License-Identifier: MIT

#include "libshape/statistics/linear_model.h"

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/require.h"
#include "libshape/statistics/linear_model_plan.h"

namespace shape {
using namespace internal;

using Eigen::MatrixXd;

void check(const PermutationOptions& options)
{
    require_at_least(0, options.permutations, "PermutationOptions.permutations");
}

LinearModelTest test_linear_model(const MatrixXd& products, const MatrixXd& tested,
                                  const MatrixXd& nuisance, const Grouping& blocks,
                                  const PermutationOptions& options)
{
    if (products.rows() != products.cols())
        throw InvalidInput(join("linear model: inner products are ", products.rows(), " by ",
                                products.cols(), ", must be square"));
    if (!products.allFinite())
        throw InvalidInput("linear model: an entry is not finite");
    LinearModelPlan plan(all_points(products.rows()), tested, nuisance, blocks, options);
    SumQuestions questions;
    plan.ask(questions);
    return plan.conclude(answer(products, questions));
}

} // namespace shape
