// SPDX-License-Identifier: MIT

#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "libshape/statistics/group_comparison.h"
#include "libshape/statistics/group_fit.h"
#include "libshape/statistics/group_spread.h"
#include "libshape/statistics/linear_model_plan.h"

namespace shape::internal {

/// compare_groups() before anything is known of the points.
class GroupComparisonPlan
{
public:
    /// @throws InvalidInput as compare_groups(), but for what concerns the points.
    GroupComparisonPlan(const Grouping& groups, const Grouping& blocks,
                        const Eigen::MatrixXd& covariates, const PermutationOptions& options);

    /// Adds its questions; conclude() looks for the answers in the same places.
    void ask(SumQuestions& questions);
    [[nodiscard]] GroupComparison conclude(const SumAnswers& answers) const;

    // The test of all groups alone.
    void ask_overall(SumQuestions& questions);
    [[nodiscard]] LinearModelTest conclude_overall(const SumAnswers& answers) const;

private:
    struct Pair
    {
        int first, second;
        std::optional<LinearModelPlan> test; ///< None where no degree of freedom is left.
    };
    Grouping groups_;
    BlockDesign design_;
    std::shared_ptr<const GroupFit> fit_;
    std::optional<LinearModelPlan> overall_;
    std::vector<Pair> pairs_; ///< None of two groups, whose test is the overall one.
    std::size_t means_ = 0;
};

/// group_spread() before anything is known of the points.
class GroupSpreadPlan
{
public:
    /// @throws InvalidInput as check().
    GroupSpreadPlan(const std::shared_ptr<const GroupFit>& fit, const BootstrapOptions& options);

    void ask(SumQuestions& questions);
    /// @throws InvalidInput if each replicate leaves a group, or a covariate, without what it takes.
    [[nodiscard]] GroupSpread conclude(const SumAnswers& answers) const;
    /// test_spread().
    [[nodiscard]] LinearModelTest conclude_test(const SumAnswers& answers,
                                                const PermutationOptions& options) const;

private:
    struct Model;
    std::shared_ptr<const Model> model_;
    std::size_t first_family_ = 0;
    std::size_t residuals_ = 0;
};

/// test_spread() from the squared distances of the rows from what is expected of them, R.
[[nodiscard]] LinearModelTest test_spread_of(const GroupFit& fit, const Eigen::VectorXd& squares,
                                             const PermutationOptions& options);

} // namespace shape::internal
