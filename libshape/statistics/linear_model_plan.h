// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <memory>
#include <vector>

#include "libshape/linalg/dense.h"
#include "libshape/statistics/linear_model.h"
#include "libshape/statistics/point_sums.h"

namespace shape::internal {

/// Observations made of points: each is a weighted sum of some, and a point belongs to one or none.
struct Observations
{
    std::vector<int> points; ///< Those that belong to one, ascending.
    std::vector<int> row_of; ///< The observation of each.
    Eigen::VectorXd shares;  ///< The weight of each.
    Eigen::Index count = 0;
};

/// Every point an observation.
[[nodiscard]] Observations all_points(Eigen::Index count);

/// The columns of a design about their means in each block.
struct DesignColumns
{
    RowMatrix all; ///< Tested and nuisance, of length 1; 0 where they are constant in the blocks.
    Eigen::MatrixXd tested; ///< Orthonormal basis of what the tested ones are beyond the nuisance.
    Eigen::MatrixXd nuisance; ///< Orthonormal basis of the nuisance.
};

[[nodiscard]] DesignColumns design_columns(const Eigen::MatrixXd& tested,
                                           const Eigen::MatrixXd& nuisance,
                                           const std::vector<std::vector<int>>& blocks);

/// A test of test_linear_model() before anything is known of the points: what it asks of them, and the
/// result once that is answered.
class LinearModelPlan
{
public:
    /// @param tested, nuisance, blocks  Of the observations.
    /// @throws InvalidInput as test_linear_model(), but for what concerns the points.
    LinearModelPlan(Observations observations, const Eigen::MatrixXd& tested,
                    const Eigen::MatrixXd& nuisance, const Grouping& blocks,
                    const PermutationOptions& options);

    /// Adds its questions; conclude() looks for the answers in the same places.
    void ask(SumQuestions& questions);
    /// @throws InvalidInput if the points do not vary within the blocks.
    [[nodiscard]] LinearModelTest conclude(const SumAnswers& answers) const;

private:
    [[nodiscard]] SumFamily family() const;

    struct Model; ///< What the questions refer to.
    std::shared_ptr<const Model> model_;
    LinearModelTest degrees_; ///< The degrees of freedom alone.
    std::size_t family_ = 0;
    std::size_t first_part_ = 0;
};

} // namespace shape::internal
