// SPDX-License-Identifier: MIT

#include "libshape/statistics/close_rows.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/to_size.h"

namespace shape::internal {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

double square_distance(const MatrixXd& products, Index i, Index j)
{
    return std::max(0.0, products(i, i) + products(j, j) - 2.0 * products(i, j));
}

/// A step of the shortest tree through all observations.
struct Step
{
    double length;
    Index from, to;
};

/// Ascending (Prim 1957).
std::vector<Step> shortest_tree(const MatrixXd& products)
{
    const Index count = products.rows();
    std::vector<Step> nearest; // of each observation outside to one inside
    for (Index i = 1; i < count; ++i)
        nearest.push_back({square_distance(products, 0, i), 0, i});
    std::vector<Step> tree;
    while (!nearest.empty()) {
        const auto next =
            std::min_element(nearest.begin(), nearest.end(),
                             [](const Step& a, const Step& b) { return a.length < b.length; });
        const Step taken = *next;
        nearest.erase(next);
        tree.push_back({std::sqrt(taken.length), taken.from, taken.to});
        for (Step& step : nearest)
            if (const double square = square_distance(products, taken.to, step.to);
                square < step.length)
                step = {square, taken.to, step.to};
    }
    std::stable_sort(tree.begin(), tree.end(),
                     [](const Step& a, const Step& b) { return a.length < b.length; });
    return tree;
}

/// What the first steps join.
Grouping joined_by(const std::vector<Step>& tree, std::size_t steps)
{
    std::vector<std::size_t> set_of(tree.size() + 1);
    for (std::size_t i = 0; i < set_of.size(); ++i)
        set_of[i] = i;
    const auto set = [&](std::size_t i) {
        while (set_of[i] != i)
            i = set_of[i] = set_of[set_of[i]];
        return i;
    };
    for (std::size_t s = 0; s < steps; ++s)
        set_of[set(to_size(tree[s].from))] = set(to_size(tree[s].to));
    std::vector<std::string> values;
    for (std::size_t i = 0; i < set_of.size(); ++i)
        values.push_back(std::to_string(set(i)));
    return group_by(values);
}

} // namespace

double closeness(const MatrixXd& products, const Grouping& blocks, const Grouping& strata)
{
    const Index count = products.rows();
    if (blocks.size() != count || strata.size() != count)
        throw InvalidInput(join("closeness: blocks are of ", blocks.size(), ", strata of ",
                                strata.size(), " observations, there are ", count));
    double within = 0.0, between = 0.0;
    Index pairs_within = 0, pairs_between = 0;
    for (Index j = 0; j < count; ++j)
        for (Index i = 0; i < j; ++i) {
            const auto a = to_size(i);
            const auto b = to_size(j);
            if (strata.group_of[a] != strata.group_of[b])
                continue;
            const bool is_within = blocks.group_of[a] == blocks.group_of[b];
            (is_within ? within : between) += square_distance(products, i, j);
            ++(is_within ? pairs_within : pairs_between);
        }
    if (pairs_within == 0 || between == 0.0)
        return std::numeric_limits<double>::infinity();
    return std::sqrt(within / static_cast<double>(pairs_within) /
                     (between / static_cast<double>(pairs_between)));
}

std::optional<Grouping> close_sets(const MatrixXd& products)
{
    constexpr Index least_observations = 6;
    constexpr std::size_t least_sets = 3;
    constexpr double least_gap = 3.0;
    constexpr double rounding = 1e-6; // of the largest step: distances of products are no better
    if (products.rows() < least_observations)
        return std::nullopt;
    const std::vector<Step> tree = shortest_tree(products);
    const auto count = to_size(products.rows());
    const double least = rounding * tree.back().length;
    std::size_t best = 0;
    double widest = least_gap;
    for (std::size_t steps = (count + 1) / 2; count - steps >= least_sets; ++steps) {
        const double gap = tree[steps].length / std::max(tree[steps - 1].length, least);
        if (gap >= widest) {
            widest = gap;
            best = steps;
        }
    }
    return best > 0 ? std::optional(joined_by(tree, best)) : std::nullopt;
}

} // namespace shape::internal
