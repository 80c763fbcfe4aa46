// SPDX-License-Identifier: MIT

#include "libshape/statistics/group_spread.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/threads.h"
#include "libshape/base/to_size.h"
#include "libshape/statistics/bootstrap_draws.h"
#include "libshape/statistics/group_plans.h"
#include "libshape/statistics/streamed_sums.h"

namespace shape {
using namespace internal;
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Distances between points with these inner products.
MatrixXd distances_of(const MatrixXd& products)
{
    const VectorXd squares = products.diagonal();
    MatrixXd result = -products - products.transpose();
    result.colwise() += squares;
    result.rowwise() += squares.transpose();
    return result.cwiseMax(0.0).cwiseSqrt();
}

} // namespace

struct internal::GroupSpreadPlan::Model
{
    Grouping groups;
    std::vector<std::vector<int>> members;
    BootstrapOptions options;
    BootstrapDraws draws;

    /// How many members of each group a replicate draws, G.
    [[nodiscard]] VectorXd drawn(const VectorXd& times) const
    {
        VectorXd counts(groups.group_count());
        for (std::size_t g = 0; g < members.size(); ++g)
            counts[static_cast<Index>(g)] = times(members[g]).sum();
        return counts;
    }
};

namespace internal {
namespace {

Resampling resampling(const Grouping& groups, const Grouping& blocks)
{
    const bool is_nested = block_design(groups, blocks) == BlockDesign::Nested;
    return {blocks, is_nested ? groups : one_group(groups.size())};
}

} // namespace

GroupSpreadPlan::GroupSpreadPlan(const Grouping& groups, const Grouping& blocks,
                                 const BootstrapOptions& options)
    : model_(std::make_shared<const Model>(
          Model{groups, members(groups), options, {resampling(groups, blocks), options}}))
{
}

/// How far the mean of each group moves when its members are drawn anew; 0 if none is drawn.
void GroupSpreadPlan::ask(SumQuestions& questions)
{
    questions.groups = model_->groups;
    first_family_ = questions.families.size();
    questions.families.push_back(means_of(model_->members));
    SumFamily moves{model_->options.replicates, {}, {}, 0};
    for (const std::vector<int>& group : model_->members)
        moves.columns.push_back({1, group});
    moves.bytes_per_member = 4 * to_size(model_->groups.size());
    moves.prepare = [model = model_](Index begin, Index end) -> SumFamily::Fill {
        std::vector<Eigen::VectorXf> times; // small whole numbers
        std::vector<VectorXd> counts;
        for (Index r = begin; r < end; ++r) {
            const VectorXd drawn = model->draws.times(static_cast<int>(r));
            times.emplace_back(drawn.cast<float>());
            counts.push_back(model->drawn(drawn));
        }
        return [model, begin, times = std::move(times), counts = std::move(counts)](
                   Index member, std::size_t set, std::size_t first, Block weights) {
            const std::size_t r = to_size(member - begin);
            const double count = counts[r][static_cast<Index>(set)];
            const std::vector<int>& group = model->members[set];
            const double share = 1.0 / static_cast<double>(group.size());
            for (Index i = 0; i < weights.rows(); ++i)
                weights(i, 0) =
                    count > 0.0
                        ? static_cast<double>(times[r][group[first + to_size(i)]]) / count - share
                        : 0.0;
        };
    };
    questions.families.push_back(std::move(moves));
}

GroupSpread GroupSpreadPlan::conclude(const SumAnswers& answers) const
{
    const MatrixXd& means = answers.families[first_family_].front();
    const std::vector<MatrixXd>& moves = answers.families[first_family_ + 1];
    const Index group_count = model_->groups.group_count();
    const auto variances = [&](const VectorXd& times, const VectorXd& moved) {
        VectorXd result(group_count);
        for (Index g = 0; g < group_count; ++g) {
            const std::vector<int>& group = model_->members[to_size(g)];
            const VectorXd own = times(group);
            const double count = own.sum();
            const double squares = own.dot(answers.squares_about_means(group));
            result[g] = std::max(squares - count * moved[g], 0.0) / std::max(count - 1.0, 1.0);
        }
        return result;
    };
    RowMatrix replicates(static_cast<Index>(moves.size()), group_count + group_count * group_count);
    parallel_for(moves.size(), 1, [&](std::size_t r, std::size_t) {
        const VectorXd times = model_->draws.times(static_cast<int>(r));
        auto row = replicates.row(static_cast<Index>(r));
        if (model_->drawn(times).minCoeff() == 0.0) {
            row.setConstant(std::numeric_limits<double>::quiet_NaN());
            return;
        }
        row.head(group_count) = variances(times, moves[r].diagonal()).transpose();
        row.tail(group_count * group_count) = distances_of(moves[r]).reshaped().transpose();
    });

    GroupSpread result;
    result.distances = distances_of(means);
    result.distance_radii = RowMatrix::Zero(group_count, group_count);
    const VectorXd measured =
        variances(VectorXd::Ones(model_->groups.size()), VectorXd::Zero(group_count));
    const double confidence = model_->options.confidence;
    for (Index g = 0; g < group_count; ++g) {
        result.variances.push_back(measured[g]);
        result.variance_intervals.push_back(percentile_interval(replicates.col(g), confidence));
        for (Index h = 0; h < g; ++h)
            result.distance_radii(g, h) = result.distance_radii(h, g) =
                quantile(replicates.col(group_count + g + h * group_count), confidence);
    }
    return result;
}

LinearModelTest test_spread_of_distances(VectorXd distances, const Grouping& groups,
                                         const Grouping& blocks, const PermutationOptions& options)
{
    // The mean of two lies in the middle: their distances are the same one, whatever the points are.
    constexpr std::size_t least_members = 3;
    std::vector<int> tested;
    int groups_tested = 0;
    for (const std::vector<int>& group : members(groups))
        if (group.size() >= least_members) {
            tested.insert(tested.end(), group.begin(), group.end());
            ++groups_tested;
        }
    if (groups_tested < 2)
        return {};
    if (groups_tested < groups.group_count()) {
        std::sort(tested.begin(), tested.end());
        return test_spread_of_distances(distances(tested), subset(groups, tested),
                                        subset(blocks, tested), options);
    }
    for (const std::vector<int>& group : members(groups)) {
        const auto count = static_cast<double>(group.size());
        if (group.size() > 1)
            distances(group) *= std::sqrt(count / (count - 1.0));
    }
    distances.array() -= distances.mean();
    GroupComparisonPlan plan(groups, blocks, MatrixXd(distances.size(), 0), options);
    SumQuestions questions;
    plan.ask_overall(questions);
    return plan.conclude_overall(answer_in_memory(distances, questions));
}

} // namespace internal

GroupSpread group_spread(const MatrixXd& products, const Grouping& groups, const Grouping& blocks,
                         const BootstrapOptions& options)
{
    const Index count = products.rows();
    if (products.cols() != count || groups.size() != count || blocks.size() != count)
        throw InvalidInput(join("groups: inner products are ", count, " by ", products.cols(),
                                ", groups ", groups.size(), ", blocks ", blocks.size(),
                                "; all must agree"));
    GroupSpreadPlan plan(groups, blocks, options);
    SumQuestions questions;
    plan.ask(questions);
    return plan.conclude(answer(products, questions));
}

LinearModelTest test_spread(const MatrixXd& products, const Grouping& groups,
                            const Grouping& blocks, const PermutationOptions& options)
{
    SumQuestions questions;
    questions.groups = groups;
    return test_spread_of_distances(answer(products, questions).squares_about_means.cwiseSqrt(),
                                    groups, blocks, options);
}

} // namespace shape
