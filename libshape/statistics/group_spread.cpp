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
#include "libshape/statistics/group_fit.h"
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
    std::shared_ptr<const GroupFit> fit;
    BootstrapOptions options;
    BootstrapDraws draws;
};

namespace internal {
namespace {

Resampling resampling(const GroupRows& rows)
{
    const bool is_nested = rows.design == BlockDesign::Nested;
    return {rows.blocks, is_nested ? rows.groups : one_group(rows.groups.size())};
}

constexpr double not_determined = std::numeric_limits<double>::quiet_NaN();

/// Degrees of freedom and shares of them below this are what rounding leaves of none.
constexpr double rounding = 1e-9;

/// What a mean of squared distances from what is expected of the rows is multiplied with: (n - 1) over what is left
/// of the n rows beside mean and slopes; NaN if nothing is.
double loss_of_slopes(const GroupFit& fit, const VectorXd& leverages, const std::vector<int>& rows)
{
    if (!fit.is_adjusted())
        return 1.0;
    if (fit.has_slope_of_one_block())
        return not_determined;
    const double left = (1.0 - leverages(rows).array()).sum();
    return left > rounding ? static_cast<double>(rows.size() - 1) / left : not_determined;
}

/// How many rows tell two groups apart, as far as resampling them shows it; on the diagonal, the rows of a group. Of
/// a chain of groups, neighbours of which have blocks in common, the link of fewest blocks counts, and of several
/// chains the best one.
Eigen::MatrixXi rows_between(const GroupRows& rows)
{
    const Index count = rows.groups.group_count();
    Eigen::MatrixXi result = Eigen::MatrixXi::Zero(count, count);
    for (const std::vector<int>& block : shape::members(rows.blocks))
        for (const int i : block)
            for (const int j : block)
                ++result(rows.groups.group_of[to_size(i)], rows.groups.group_of[to_size(j)]);
    for (Index via = 0; via < count; ++via)
        for (Index g = 0; g < count; ++g)
            for (Index h = 0; h < count; ++h)
                result(g, h) = std::max(result(g, h), std::min(result(g, via), result(via, h)));
    for (Index g = 0; g < count; ++g)
        for (Index h = 0; h < count; ++h)
            if (result(g, h) == 0) // nothing links them: each has rows of its own
                result(g, h) = std::min(result(g, g), result(h, h));
    return result;
}

} // namespace

GroupSpreadPlan::GroupSpreadPlan(const std::shared_ptr<const GroupFit>& fit,
                                 const BootstrapOptions& options)
    : model_(std::make_shared<const Model>(
          Model{fit, options, BootstrapDraws(resampling(fit->rows()), options)}))
{
}

/// How far the mean of each group moves when its members are drawn anew; 0 if none is drawn.
void GroupSpreadPlan::ask(SumQuestions& questions)
{
    const GroupFit& fit = *model_->fit;
    residuals_ = ask_for_residuals(fit, questions);
    first_family_ = questions.families.size();
    questions.families.push_back(means_of(model_->fit));
    const Index group_count = fit.rows().groups.group_count();
    SumFamily moves{model_->options.replicates, columns_of(fit, 2 * group_count), {}, 0};
    moves.bytes_per_member = 4 * to_size(fit.rows().observations.count) +
                             (fit.is_direct() ? 0 : 8 * to_size(6 * group_count * group_count));
    moves.prepare = [model = model_](Index begin, Index end) -> SumFamily::Fill {
        std::vector<Eigen::VectorXf> times; // small whole numbers
        std::vector<GroupFit::Solution> solutions;
        for (Index r = begin; r < end; ++r) {
            const VectorXd drawn = model->draws.times(static_cast<int>(r));
            times.emplace_back(drawn.cast<float>());
            solutions.push_back(model->fit->solve(drawn));
        }
        return [model, begin, times = std::move(times), solutions = std::move(solutions)](
                   Index member, std::size_t set, std::size_t first, Block weights) {
            const GroupFit& own = *model->fit;
            const Observations& all = own.rows().observations;
            const std::size_t r = to_size(member - begin);
            const auto group = static_cast<Index>(set);
            for (Index i = 0; i < weights.rows(); ++i) {
                const std::size_t number = first + to_size(i);
                const std::size_t place =
                    own.is_direct() ? to_size(own.places()[set][number]) : number;
                const Index row = all.row_of[place];
                const double drawn = static_cast<double>(times[r][row]);
                const double count = solutions[r].counts[group];
                if (!own.is_direct() && solutions[r].is_determined)
                    own.fill_moves(solutions[r], drawn, row, weights.row(i));
                else if (own.is_direct() && count > 0.0)
                    weights(i, 0) = drawn / count - own.row_weights()(row, group);
                else
                    weights.row(i).setZero();
                weights.row(i) *= all.shares[static_cast<Index>(place)];
            }
        };
    };
    questions.families.push_back(std::move(moves));
}

GroupSpread GroupSpreadPlan::conclude(const SumAnswers& answers) const
{
    const GroupFit& fit = *model_->fit;
    const VectorXd& squares = squared_residuals(fit, answers, residuals_);
    const MatrixXd& means = answers.families[first_family_].front();
    const std::vector<MatrixXd>& moves = answers.families[first_family_ + 1];
    const Index group_count = fit.rows().groups.group_count();
    const VectorXd leverages = fit.leverages();
    const auto variances = [&](const VectorXd& times, const VectorXd& moved) {
        VectorXd result(group_count);
        for (Index g = 0; g < group_count; ++g) {
            const std::vector<int>& group = fit.members()[to_size(g)];
            const VectorXd own = times(group);
            const double count = own.sum();
            const double sum = own.dot(squares(group));
            result[g] = count < 2.0 ? not_determined // it is its mean
                                    : std::max(sum - count * moved[g], 0.0) / (count - 1.0) *
                                          loss_of_slopes(fit, leverages, group);
        }
        return result;
    };
    RowMatrix replicates(static_cast<Index>(moves.size()), group_count + group_count * group_count);
    parallel_for(moves.size(), 1, [&](std::size_t r, std::size_t) {
        const VectorXd times = model_->draws.times(static_cast<int>(r));
        auto row = replicates.row(static_cast<Index>(r));
        if (!fit.solve(times).is_determined) {
            row.setConstant(not_determined);
            return;
        }
        // Behind the moves of the means, if they are others, are those of the residuals.
        row.head(group_count) = variances(times, moves[r].diagonal().tail(group_count)).transpose();
        row.tail(group_count * group_count) =
            distances_of(moves[r].topLeftCorner(group_count, group_count)).reshaped().transpose();
    });
    if (replicates.rightCols<1>().array().isNaN().all()) // a distance, of a group from itself
        throw InvalidInput(join("groups: each of the ", moves.size(),
                                " replicates of the bootstrap leaves a group without members or a "
                                "covariate without variation; draw more of them"));

    GroupSpread result;
    result.distances = distances_of(means);
    result.distance_radii = RowMatrix::Zero(group_count, group_count);
    const VectorXd measured =
        variances(VectorXd::Ones(fit.rows().observations.count), VectorXd::Zero(group_count));
    const double confidence = model_->options.confidence;
    const bool are_enough =
        (!replicates.rightCols<1>().array().isNaN()).count() >= least_replicates(confidence);
    const Eigen::MatrixXi tell = rows_between(fit.rows());
    for (Index g = 0; g < group_count; ++g) {
        result.counts.push_back(static_cast<int>(fit.members()[to_size(g)].size()));
        result.variances.push_back(measured[g]);
        result.variance_intervals.push_back(tell(g, g) >= least_resampled
                                                ? percentile_interval(replicates.col(g), confidence)
                                                : Interval{not_determined, not_determined});
        for (Index h = 0; h < g; ++h)
            result.distance_radii(g, h) = result.distance_radii(h, g) =
                are_enough && tell(g, h) >= least_resampled
                    ? quantile(replicates.col(group_count + g + h * group_count), confidence)
                    : not_determined;
    }
    for (int g = 0; g < fit.rows().groups.group_count(); ++g)
        for (int h = 0; h < fit.rows().groups.group_count(); ++h)
            if (!fit.is_determined(g, h))
                result.distances(g, h) = result.distance_radii(g, h) = not_determined;
    return result;
}

LinearModelTest GroupSpreadPlan::conclude_test(const SumAnswers& answers,
                                               const PermutationOptions& options) const
{
    const GroupFit& fit = *model_->fit;
    return test_spread_of(fit, squared_residuals(fit, answers, residuals_), options);
}

LinearModelTest test_spread_of(const GroupFit& fit, const VectorXd& squares,
                               const PermutationOptions& options)
{
    check(options);
    if (fit.has_slope_of_one_block())
        return {};
    // The mean of two lies in the middle: their distances are the same one, whatever the points are.
    constexpr std::size_t least_members = 3;
    VectorXd distances = squares.cwiseSqrt();
    const VectorXd leverages = fit.leverages();
    std::vector<int> tested;
    int groups_tested = 0;
    for (const std::vector<int>& group : fit.members()) {
        const auto count = static_cast<double>(group.size());
        std::vector<int> free = group; // rows that can differ from what is expected of them
        if (fit.is_adjusted()) {
            std::erase_if(free, [&](int row) { return 1.0 - leverages[row] <= rounding; });
            for (const int row : free)
                distances[row] /= std::sqrt(1.0 - leverages[row]);
        } else if (group.size() > 1) {
            distances(group) *= std::sqrt(count / (count - 1.0));
        }
        if (free.size() >= least_members) {
            tested.insert(tested.end(), free.begin(), free.end());
            ++groups_tested;
        }
    }
    if (groups_tested < 2)
        return {};
    std::sort(tested.begin(), tested.end());
    const bool are_all = std::cmp_equal(tested.size(), fit.rows().observations.count);
    const GroupRows& rows = fit.rows();
    const Grouping groups = are_all ? rows.groups : subset(rows.groups, tested);
    const Grouping blocks = are_all ? rows.blocks : subset(rows.blocks, tested);
    VectorXd kept = distances(tested);
    kept.array() -= kept.mean();
    try {
        GroupComparisonPlan plan(groups, blocks, MatrixXd(kept.size(), 0), options);
        SumQuestions questions;
        plan.ask_overall(questions);
        return plan.conclude_overall(answer_in_memory(kept, questions));
    } catch (const InvalidInput&) {
        return {}; // too few are left, or all are as far as the others of their block
    }
}

} // namespace internal

namespace {

void check_observations(const MatrixXd& products, const Grouping& groups, const Grouping& blocks,
                        const MatrixXd& covariates)
{
    const Index count = products.rows();
    if (products.cols() != count || groups.size() != count || blocks.size() != count ||
        covariates.rows() != count)
        throw InvalidInput(join("groups: inner products are ", count, " by ", products.cols(),
                                ", groups ", groups.size(), ", blocks ", blocks.size(),
                                ", covariates ", covariates.rows(), " rows; all must agree"));
}

} // namespace

GroupSpread group_spread(const MatrixXd& products, const Grouping& groups, const Grouping& blocks,
                         const MatrixXd& covariates, const BootstrapOptions& options)
{
    check_observations(products, groups, blocks, covariates);
    GroupSpreadPlan plan(std::make_shared<const GroupFit>(groups, blocks, covariates), options);
    SumQuestions questions;
    plan.ask(questions);
    return plan.conclude(answer(products, questions));
}

LinearModelTest test_spread(const MatrixXd& products, const Grouping& groups,
                            const Grouping& blocks, const MatrixXd& covariates,
                            const PermutationOptions& options)
{
    check_observations(products, groups, blocks, covariates);
    const GroupFit fit(groups, blocks, covariates);
    SumQuestions questions;
    const std::size_t residuals = ask_for_residuals(fit, questions);
    return test_spread_of(fit, squared_residuals(fit, answer(products, questions), residuals),
                          options);
}

} // namespace shape
