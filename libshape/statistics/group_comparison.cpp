// SPDX-License-Identifier: MIT

#include "libshape/statistics/group_comparison.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <map>
#include <memory>
#include <set>
#include <utility>
#include <vector>

#include "libshape/base/counted.h"
#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/to_size.h"
#include "libshape/statistics/group_plans.h"

namespace shape {
using namespace internal;
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

/// Observations with their groups, blocks and covariates.
struct Design
{
    Observations observations;
    Grouping groups;
    Grouping blocks;
    MatrixXd covariates;
};

Design subset(const Design& design, const std::vector<int>& kept)
{
    std::vector<int> number(to_size(design.observations.count), -1);
    for (std::size_t i = 0; i < kept.size(); ++i)
        number[to_size(kept[i])] = static_cast<int>(i);
    const Observations& all = design.observations;
    Observations observations;
    observations.count = static_cast<Index>(kept.size());
    std::vector<Index> places;
    for (std::size_t i = 0; i < all.points.size(); ++i)
        if (const int row = number[to_size(all.row_of[i])]; row >= 0) {
            observations.points.push_back(all.points[i]);
            observations.row_of.push_back(row);
            places.push_back(static_cast<Index>(i));
        }
    observations.shares = all.shares(places);
    return {std::move(observations), subset(design.groups, kept), subset(design.blocks, kept),
            design.covariates(kept, Eigen::all)};
}

/// How many groups each block has members of.
std::vector<std::size_t> groups_per_block(const Grouping& groups, const Grouping& blocks)
{
    std::vector<std::size_t> counts;
    for (const std::vector<int>& block : members(blocks)) {
        std::set<int> found;
        for (const int i : block)
            found.insert(groups.group_of[to_size(i)]);
        counts.push_back(found.size());
    }
    return counts;
}

/// Observations of one set as one, their mean; blocks and groups are those of the first.
Design means_of(const Design& design, const Grouping& sets)
{
    const std::vector<std::vector<int>> lists = members(sets);
    const auto count = static_cast<Index>(lists.size());
    if (count == design.groups.size())
        return design;
    Observations means = design.observations;
    means.count = count;
    MatrixXd covariates = MatrixXd::Zero(count, design.covariates.cols());
    for (std::size_t i = 0; i < means.row_of.size(); ++i) {
        const int set = sets.group_of[to_size(means.row_of[i])];
        means.row_of[i] = set;
        means.shares[static_cast<Index>(i)] /= static_cast<double>(lists[to_size(set)].size());
    }
    std::vector<int> representatives;
    for (std::size_t b = 0; b < lists.size(); ++b) {
        representatives.push_back(lists[b].front());
        covariates.row(static_cast<Index>(b)) =
            design.covariates(lists[b], Eigen::all).colwise().mean();
    }
    return {std::move(means), subset(design.groups, representatives),
            subset(design.blocks, representatives), std::move(covariates)};
}

/// The members that a block has of a group, numbered by the first of each.
Grouping cells(const Design& design)
{
    Grouping result;
    std::map<std::pair<int, int>, int> numbers;
    for (std::size_t i = 0; i < design.groups.group_of.size(); ++i) {
        const auto [place, is_new] = numbers.try_emplace(
            {design.blocks.group_of[i], design.groups.group_of[i]}, result.group_count());
        if (is_new)
            result.names.push_back(std::to_string(place->second));
        result.group_of.push_back(place->second);
    }
    return result;
}

/// Without the blocks that have one group alone: they say nothing of differences between groups.
Design blocks_of_several_groups(const Design& design)
{
    const std::vector<std::size_t> counts = groups_per_block(design.groups, design.blocks);
    std::vector<int> kept;
    for (std::size_t i = 0; i < design.blocks.group_of.size(); ++i)
        if (counts[to_size(design.blocks.group_of[i])] > 1)
            kept.push_back(static_cast<int>(i));
    return subset(design, kept);
}

/// What is compared: the blocks' means; or within the blocks their means in each group. Members of one block and group
/// are nearer to each other than to those of other blocks: they say how well a block was measured, not how much
/// blocks differ in what tells the groups apart.
Design exchangeable(const Design& design)
{
    if (block_design(design.groups, design.blocks) == BlockDesign::Crossed) {
        const Design several = blocks_of_several_groups(design);
        return means_of(several, cells(several));
    }
    Design means = means_of(design, design.blocks);
    means.blocks = one_group(means.groups.size());
    return means;
}

LinearModelPlan plan_test(Design design, const PermutationOptions& options)
{
    const MatrixXd tested = indicators(design.groups);
    return {std::move(design.observations), tested, design.covariates, design.blocks, options};
}

/// Whether anything is left over to measure the difference of two groups by.
bool is_testable_pair(const Design& design)
{
    return design.groups.size() - design.blocks.group_count() - design.covariates.cols() >= 2;
}

void check(const Design& design)
{
    const Index count = design.observations.count;
    if (design.groups.group_count() < 2)
        throw InvalidInput(
            join("groups: all ", count, " observations are in one group; at least two are needed"));
    if (count <= design.groups.group_count())
        throw InvalidInput(join("groups: ", count, " observations in ", design.groups.group_count(),
                                " groups; there must be more observations than groups"));
}

/// Of blocks with members of several groups there may be few, after a slip in a table that made them so.
void check_compared(const Design& compared, BlockDesign design)
{
    const int blocks = compared.blocks.group_count();
    const int least = blocks + compared.groups.group_count();
    if (design == BlockDesign::Nested || compared.observations.count >= least)
        return;
    std::string names;
    for (const std::string& name : compared.blocks.names)
        names += join(names.empty() ? "'" : ", '", name, "'");
    throw InvalidInput(join(
        "groups: ", counted(blocks, "block has", "blocks have"), " members of several groups (",
        names, "), ", compared.observations.count,
        " means in all, as each counts once in a group; ", "to compare ",
        compared.groups.group_count(), " groups within ", blocks == 1 ? "it" : "them", " takes ",
        least, " at the least. If that is a slip, correct it; else compare without blocks"));
}

/// What body() gives; an error of it names the groups.
template <class Body>
auto of_pair(const Grouping& groups, int first, int second, const Body& body)
{
    try {
        return body();
    } catch (const InvalidInput& error) {
        throw InvalidInput(join("groups '", groups.names[to_size(first)], "' and '",
                                groups.names[to_size(second)], "': ", error.what()));
    }
}

} // namespace

BlockDesign block_design(const Grouping& groups, const Grouping& blocks)
{
    if (groups.size() != blocks.size())
        throw InvalidInput(join("block design: groups are of ", groups.size(),
                                " observations, blocks of ", blocks.size()));
    const std::vector<std::size_t> counts = groups_per_block(groups, blocks);
    const bool is_nested = std::all_of(counts.begin(), counts.end(), [](auto c) { return c == 1; });
    return is_nested ? BlockDesign::Nested : BlockDesign::Crossed;
}

namespace internal {

GroupComparisonPlan::GroupComparisonPlan(const Grouping& groups, const Grouping& blocks,
                                         const MatrixXd& covariates,
                                         const PermutationOptions& options)
    : groups_(groups), design_(block_design(groups, blocks))
{
    const Design design{all_points(groups.size()), groups, blocks, covariates};
    check(design);
    fit_ = std::make_shared<const GroupFit>(groups, blocks, covariates);
    if (design_ == BlockDesign::Nested && blocks.group_count() <= groups.group_count())
        throw InvalidInput(join("groups: ", blocks.group_count(), " blocks in ",
                                groups.group_count(),
                                " groups; there must be more blocks than groups"));
    Design compared = exchangeable(design);
    check_compared(compared, design_);
    overall_ = plan_test(std::move(compared), options);
    const std::vector<std::vector<int>> lists = members(groups);
    const int count = groups.group_count();
    for (int first = 0; count > 2 && first < count; ++first)
        for (int second = first + 1; second < count; ++second)
            pairs_.push_back(of_pair(groups, first, second, [&]() -> Pair {
                std::vector<int> both;
                std::ranges::merge(lists[to_size(first)], lists[to_size(second)],
                                   std::back_inserter(both));
                Design of_both = exchangeable(subset(design, both));
                if (!is_testable_pair(of_both))
                    return {first, second, std::nullopt};
                return {first, second, plan_test(std::move(of_both), options)};
            }));
}

void GroupComparisonPlan::ask_overall(SumQuestions& questions)
{
    overall_->ask(questions);
}

LinearModelTest GroupComparisonPlan::conclude_overall(const SumAnswers& answers) const
{
    return overall_->conclude(answers);
}

void GroupComparisonPlan::ask(SumQuestions& questions)
{
    ask_overall(questions);
    means_ = questions.families.size();
    questions.families.push_back(means_of(fit_));
    for (Pair& pair : pairs_)
        if (pair.test)
            pair.test->ask(questions);
}

GroupComparison GroupComparisonPlan::conclude(const SumAnswers& answers) const
{
    const MatrixXd& means = answers.families[means_].front();
    const auto distance = [&](int a, int b) {
        if (!fit_->is_determined(a, b))
            return std::numeric_limits<double>::quiet_NaN();
        return std::sqrt(std::max(means(a, a) + means(b, b) - 2.0 * means(a, b), 0.0));
    };
    GroupComparison result;
    result.design = design_;
    result.left_out = static_cast<int>(groups_.size()) -
                      static_cast<int>(fit_->rows().observations.points.size());
    result.overall = conclude_overall(answers);
    if (groups_.group_count() == 2)
        result.pairs.push_back({0, 1, distance(0, 1), result.overall});
    for (const Pair& pair : pairs_)
        result.pairs.push_back(of_pair(groups_, pair.first, pair.second, [&]() -> PairComparison {
            return {pair.first, pair.second, distance(pair.first, pair.second),
                    pair.test ? pair.test->conclude(answers) : LinearModelTest{}};
        }));
    Eigen::VectorXd p_values(static_cast<Index>(result.pairs.size()));
    for (Index k = 0; k < p_values.size(); ++k)
        p_values[k] = result.pairs[to_size(k)].test.p_value;
    const Eigen::VectorXd adjusted = holm_adjusted(p_values);
    for (Index k = 0; k < p_values.size(); ++k)
        result.pairs[to_size(k)].adjusted_p = adjusted[k];
    return result;
}

} // namespace internal

GroupComparison compare_groups(const MatrixXd& products, const Grouping& groups,
                               const Grouping& blocks, const MatrixXd& covariates,
                               const PermutationOptions& options)
{
    const Index count = products.rows();
    if (products.cols() != count || groups.size() != count || blocks.size() != count ||
        covariates.rows() != count)
        throw InvalidInput(join("groups: inner products are ", count, " by ", products.cols(),
                                ", groups ", groups.size(), ", blocks ", blocks.size(),
                                ", covariates ", covariates.rows(), " rows; all must agree"));
    if (!products.allFinite())
        throw InvalidInput("groups: an inner product is not finite");
    GroupComparisonPlan plan(groups, blocks, covariates, options);
    SumQuestions questions;
    plan.ask(questions);
    return plan.conclude(answer(products, questions));
}

Eigen::VectorXd holm_adjusted(const Eigen::VectorXd& p_values)
{
    std::vector<Index> order;
    for (Index k = 0; k < p_values.size(); ++k)
        if (!std::isnan(p_values[k]))
            order.push_back(k);
    std::stable_sort(order.begin(), order.end(),
                     [&](Index a, Index b) { return p_values[a] < p_values[b]; });
    Eigen::VectorXd adjusted = Eigen::VectorXd::Constant(p_values.size(), LinearModelTest::none);
    double largest = 0.0;
    for (std::size_t k = 0; k < order.size(); ++k) {
        const double factor = static_cast<double>(order.size() - k);
        largest = std::max(largest, std::min(1.0, factor * p_values[order[k]]));
        adjusted[order[k]] = largest;
    }
    return adjusted;
}

} // namespace shape
