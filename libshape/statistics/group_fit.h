// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "libshape/linalg/dense.h"
#include "libshape/statistics/group_comparison.h"
#include "libshape/statistics/grouping.h"
#include "libshape/statistics/linear_model_plan.h"
#include "libshape/statistics/point_sums.h"

// Which points make the means of groups, and by what weights: beside a test that takes blocks and covariates into
// account, means and spreads that do not would describe other data.

namespace shape::internal {

/// Whoever determines more than this share of a slope determines it alone: of eleven at the least.
constexpr double determining_share = 0.9;

/// What counts once in a group: a point; the mean of a block that lies in one group; or, of a block that has members
/// of several groups, the mean of its members in this one. Points of blocks that lie in one group, where others have
/// members of several, belong to no row, unless their group has no other blocks.
struct GroupRows
{
    BlockDesign design = BlockDesign::Nested;
    Observations observations;  ///< The R rows as weighted sums of points.
    Grouping groups;            ///< Of the rows; named and numbered as those of the points.
    Grouping blocks;            ///< Of the rows.
    Eigen::MatrixXd covariates; ///< R by C: means over the points of each row.
};

/// @throws InvalidInput if sizes disagree or a group is empty.
[[nodiscard]] GroupRows rows_of_groups(const Grouping& groups, const Grouping& blocks,
                                       const Eigen::MatrixXd& covariates);

/// The least-squares means of groups (Searle, Speed & Milliken 1980), as weights of points:
///
///     row = mean of its group + (covariates - their means) slopes [+ effect of its block if crossed] + residual.
///
/// Means are at the means of the covariates over the rows (crossed: over the blocks). Crossed, they are at the mean
/// effect of the blocks, each block once, of those that a chain of groups in common links to the group; so two means
/// differ by the mean difference within the blocks where all blocks have both groups. Without covariates, nested or
/// with such blocks, they are the means of the rows.
class GroupFit
{
public:
    /// @param covariates  N by C, C >= 0.
    /// @throws InvalidInput as rows_of_groups(), or if a covariate is not finite.
    GroupFit(const Grouping& groups, const Grouping& blocks, const Eigen::MatrixXd& covariates);

    [[nodiscard]] const GroupRows& rows() const { return rows_; }
    /// The rows of each group.
    [[nodiscard]] const std::vector<std::vector<int>>& members() const { return members_; }
    /// The places of each group in rows().observations.points.
    [[nodiscard]] const std::vector<std::vector<int>>& places() const { return places_; }
    [[nodiscard]] bool is_adjusted() const { return covariates_.cols() > 0; } ///< For covariates.
    /// Whether the means are those of the rows.
    [[nodiscard]] bool is_direct() const { return is_direct_; }
    /// Whether, moreover, each point is a row.
    [[nodiscard]] bool is_plain() const;
    /// Not if the mean of a group, or the difference of two, needs the slope of a covariate that does not vary within
    /// the groups (crossed: within the blocks).
    [[nodiscard]] bool is_determined(int group) const;
    [[nodiscard]] bool is_determined(int first, int second) const;
    /// C: where the means are.
    [[nodiscard]] const Eigen::VectorXd& covariate_means() const { return covariate_means_; }

    /// R by G: weights of the rows.
    [[nodiscard]] const RowMatrix& row_weights() const { return row_weights_; }
    /// N by G: weights of the points, columns of sum 1; NaN of a mean that is not determined.
    [[nodiscard]] Eigen::MatrixXd means() const;

    /// N by G + C: weights of the points in the means of the rows of each group, and in the slopes.
    [[nodiscard]] Eigen::MatrixXd references() const;
    /// R by G + C: how much of each of the references is expected of a row: the mean of its group, moved along the
    /// slopes to its covariates.
    [[nodiscard]] Eigen::MatrixXd expected() const;
    /// R: a row of variance 1 differs from what is expected of it by a variance of 1 - leverage. Crossed, where
    /// differences between blocks stay in what is left, what the slopes take is neglected.
    [[nodiscard]] Eigen::VectorXd leverages() const;

    /// B by C: how much of a slope each block of rows() determines, columns of sum 1; 0 of a slope that is not used.
    [[nodiscard]] Eigen::MatrixXd slope_shares() const;
    /// Whether one block determines nearly all of a slope within blocks. Applied to the differences between blocks, which
    /// may be far larger, it makes of what is left over anything.
    [[nodiscard]] bool has_slope_of_one_block() const { return has_slope_of_one_block_; }

    /// The fit to rows that count some times each.
    struct Solution
    {
        bool is_determined = false; ///< As much as that to all rows; else the rest is missing.
        Eigen::VectorXd counts;     ///< G: rows counted.
        // Missing if the fit is direct:
        Eigen::MatrixXd covariates;   ///< G by C: means over the rows of each group.
        Eigen::VectorXd part_counts;  ///< Rows (crossed: blocks) that are linked.
        Eigen::MatrixXd part_means;   ///< Of their columns.
        Eigen::MatrixXd inverse;      ///< Of the normal equations.
        Eigen::MatrixXd null_space;   ///< What these leave open, in columns.
        Eigen::MatrixXd coefficients; ///< What a row's columns, about their mean, add to each mean.
    };
    /// @param times  R; of all rows of a block the same.
    [[nodiscard]] Solution solve(const Eigen::VectorXd& times) const;

    /// How a row that counts some times moves, from the fit to all rows to a determined one, the G means, and behind
    /// them the G means of what the rows of each group differ from what was expected of them.
    void fill_moves(const Solution& solution, double times, Eigen::Index row,
                    Eigen::Ref<Eigen::RowVectorXd> weights) const;

private:
    void link_groups();
    [[nodiscard]] Eigen::MatrixXd shares_of_blocks(const Eigen::MatrixXd& columns) const;
    void set_columns();
    [[nodiscard]] int group_of(Eigen::Index row) const;
    [[nodiscard]] int part_of(Eigen::Index row) const;
    [[nodiscard]] Eigen::RowVectorXd centred(const Solution& solution, Eigen::Index row) const;
    void fill_means(const Solution& solution, double times, Eigen::Index row,
                    Eigen::Ref<Eigen::RowVectorXd> weights) const;

    GroupRows rows_;
    Eigen::Index points_;
    std::vector<std::vector<int>> members_;
    std::vector<std::vector<int>> places_;
    bool is_direct_ = true;
    std::vector<int> part_of_group_; ///< Crossed: of those that blocks link; nested: its own.
    Eigen::VectorXd block_shares_;   ///< R: crossed: 1 / rows of the block; nested: 1.
    Eigen::VectorXd covariate_means_;
    Eigen::MatrixXd covariates_;    ///< R by C: about their means, in standard deviations.
    Eigen::MatrixXd columns_;       ///< R by K: crossed: indicators of groups; then the covariates.
    Eigen::MatrixXd block_centred_; ///< R by K: crossed: columns about their means in each block.
    Eigen::MatrixXd targets_;    ///< K by G: the columns of a group at the means of the covariates.
    Eigen::Index most_open_ = 0; ///< Dimension of what the normal equations leave open.
    Solution all_;               ///< Each row once.
    Eigen::MatrixXd open_;       ///< By G: how much of what is left open is in each mean.
    RowMatrix row_weights_;      ///< R by G.
    Eigen::MatrixXd slopes_;     ///< R by C: weights of the rows in the slopes.
    bool has_slope_of_one_block_ = false;
};

/// The sums that are the means of the groups, G columns; those of undetermined ones are of no use.
[[nodiscard]] SumFamily means_of(const std::shared_ptr<const GroupFit>& fit);

/// The columns of sums that have one for each group: of a direct fit each has the points of its group.
/// @param width  Of all columns together; G of a direct fit.
[[nodiscard]] std::vector<SumColumns> columns_of(const GroupFit& fit, Eigen::Index width);

/// Asks for the squared distances of the rows from what is expected of them.
/// @return Where the answer is.
std::size_t ask_for_residuals(const GroupFit& fit, SumQuestions& questions);

/// That answer, R.
[[nodiscard]] const Eigen::VectorXd& squared_residuals(const GroupFit& fit,
                                                       const SumAnswers& answers,
                                                       std::size_t place);

} // namespace shape::internal
