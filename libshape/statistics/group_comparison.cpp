// SPDX-License-Identifier: MIT

#include "libshape/statistics/group_comparison.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>
#include <set>
#include <vector>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/to_size.h"
#include "libshape/statistics/covariate_blocks.h"

namespace shape {
using namespace internal;
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

/// Observations with their groups, blocks and covariates.
struct Design
{
    MatrixXd products;
    Grouping groups;
    Grouping blocks;
    MatrixXd covariates;
};

Design subset(const Design& design, const std::vector<int>& observations)
{
    return {design.products(observations, observations), subset(design.groups, observations),
            subset(design.blocks, observations), design.covariates(observations, Eigen::all)};
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

/// Every block as one observation, its mean.
Design means_of_blocks(const Design& design)
{
    const std::vector<std::vector<int>> blocks = members(design.blocks);
    const auto count = static_cast<Index>(blocks.size());
    if (count == design.groups.size())
        return design;
    const MatrixXd weights = mean_weights(design.blocks);
    std::vector<int> representatives;
    for (const std::vector<int>& block : blocks)
        representatives.push_back(block.front());
    return {weights.transpose() * design.products * weights, subset(design.groups, representatives),
            groups_of_one(count), weights.transpose() * design.covariates};
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

/// What is compared: the blocks' means, or the observations within the blocks.
Design exchangeable(const Design& design)
{
    if (block_design(design.groups, design.blocks) == BlockDesign::Crossed)
        return blocks_of_several_groups(design);
    Design means = means_of_blocks(design);
    means.blocks = one_group(means.groups.size());
    return means;
}

LinearModelTest test(const Design& design, const PermutationOptions& options)
{
    return test_linear_model(design.products, indicators(design.groups), design.covariates,
                             design.blocks, options);
}

/// Whether anything is left over to measure the difference of two groups by.
bool is_testable_pair(const Design& design)
{
    return design.groups.size() - design.blocks.group_count() - design.covariates.cols() >= 2;
}

double distance_of_means(const MatrixXd& products, const std::vector<int>& a,
                         const std::vector<int>& b)
{
    const double square = products(a, a).mean() + products(b, b).mean() - 2 * products(a, b).mean();
    return std::sqrt(std::max(square, 0.0));
}

PairComparison compare_pair(const Design& design, int first, int second,
                            const PermutationOptions& options)
{
    const std::vector<std::vector<int>> lists = members(design.groups);
    const std::vector<int>& a = lists[to_size(first)];
    const std::vector<int>& b = lists[to_size(second)];
    PairComparison pair;
    pair.first = first;
    pair.second = second;
    pair.distance = distance_of_means(design.products, a, b);
    std::vector<int> both;
    std::merge(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(both));
    try {
        const Design compared = exchangeable(subset(design, both));
        if (is_testable_pair(compared))
            pair.test = test(compared, options);
    } catch (const InvalidInput& error) {
        throw InvalidInput(join("groups '", design.groups.names[to_size(first)], "' and '",
                                design.groups.names[to_size(second)], "': ", error.what()));
    }
    return pair;
}

void check(const Design& design)
{
    const Index count = design.products.rows();
    if (design.products.cols() != count || design.groups.size() != count ||
        design.blocks.size() != count || design.covariates.rows() != count)
        throw InvalidInput(join("groups: inner products are ", count, " by ",
                                design.products.cols(), ", groups ", design.groups.size(),
                                ", blocks ", design.blocks.size(), ", covariates ",
                                design.covariates.rows(), " rows; all must agree"));
    if (design.groups.group_count() < 2)
        throw InvalidInput(
            join("groups: all ", count, " observations are in one group; at least two are needed"));
    if (count <= design.groups.group_count())
        throw InvalidInput(join("groups: ", count, " observations in ", design.groups.group_count(),
                                " groups; there must be more observations than groups"));
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

GroupComparison compare_groups(const MatrixXd& products, const Grouping& groups,
                               const Grouping& blocks, const MatrixXd& covariates,
                               const PermutationOptions& options)
{
    const Design design{products, groups, blocks, covariates};
    check(design);
    GroupComparison result;
    result.design = block_design(design.groups, design.blocks);
    if (result.design == BlockDesign::Nested && blocks.group_count() <= groups.group_count())
        throw InvalidInput(join("groups: ", blocks.group_count(), " blocks in ",
                                groups.group_count(),
                                " groups; there must be more blocks than groups"));
    result.overall = test(exchangeable(design), options);
    for (int first = 0; first < groups.group_count(); ++first)
        for (int second = first + 1; second < groups.group_count(); ++second)
            result.pairs.push_back(compare_pair(design, first, second, options));
    Eigen::VectorXd p_values(static_cast<Index>(result.pairs.size()));
    for (Index k = 0; k < p_values.size(); ++k)
        p_values[k] = result.pairs[to_size(k)].test.p_value;
    const Eigen::VectorXd adjusted = holm_adjusted(p_values);
    for (Index k = 0; k < p_values.size(); ++k)
        result.pairs[to_size(k)].adjusted_p = adjusted[k];
    return result;
}

Eigen::VectorXd holm_adjusted(const Eigen::VectorXd& p_values)
{
    std::vector<Index> order(to_size(p_values.size()));
    std::iota(order.begin(), order.end(), Index{0});
    std::stable_sort(order.begin(), order.end(),
                     [&](Index a, Index b) { return p_values[a] < p_values[b]; });
    Eigen::VectorXd adjusted(p_values.size());
    double largest = 0.0;
    for (std::size_t k = 0; k < order.size(); ++k) {
        const double factor = static_cast<double>(order.size() - k);
        largest = std::max(largest, std::min(1.0, factor * p_values[order[k]]));
        adjusted[order[k]] = largest;
    }
    return adjusted;
}

} // namespace shape
