// SPDX-License-Identifier: MIT

#include "tools/doubts.h"

#include <set>
#include <utility>
#include <vector>

#include "libshape/base/counted.h"
#include "libshape/base/format.h"
#include "libshape/base/to_size.h"
#include "libshape/edge_space/shape_space.h"
#include "libshape/mesh/oddities.h"
#include "libshape/statistics/group_comparison.h"
#include "libshape/statistics/group_fit.h"
#include "libshape/statistics/inner_products.h"

namespace shape::tools {
using namespace internal;

bool is_within_blocks(const Grouping& groups, const Grouping& blocks, int first, int second)
{
    std::vector<int> both;
    for (std::size_t i = 0; i < groups.group_of.size(); ++i)
        if (groups.group_of[i] == first || groups.group_of[i] == second)
            both.push_back(static_cast<int>(i));
    return block_design(subset(groups, both), subset(blocks, both)) == BlockDesign::Crossed;
}

std::optional<std::string> doubt_about_lost_meshes(const Grouping& groups, const Grouping& blocks,
                                                   const std::string& by, const std::string& within)
{
    const GroupRows rows = rows_of_groups(groups, blocks, Eigen::MatrixXd(groups.size(), 0));
    const Eigen::Index lost =
        groups.size() - static_cast<Eigen::Index>(rows.observations.points.size());
    if (2 * lost <= groups.size())
        return std::nullopt;
    std::vector<std::size_t> crossed;
    const std::vector<std::vector<int>> lists = members(blocks);
    for (std::size_t b = 0; b < lists.size(); ++b)
        if (subset(groups, lists[b]).group_count() > 1)
            crossed.push_back(b);
    return join(lost, " of ", counted(groups.size(), "mesh", "meshes"), " are left out: as ",
                list_names(blocks.names, crossed), ", ", crossed.size(), " of ",
                counted(blocks.group_count(), "block"), " of --within ", within, ", ",
                crossed.size() == 1 ? "has" : "have",
                " meshes of several groups, groups are compared within such blocks alone. If that "
                "is a slip, correct the values of ",
                by, " or ", within);
}

RepetitionQuestion rows_of_comparison(const Grouping& groups, const std::string& by)
{
    return {.covariates = codes(groups),
            .columns = {by},
            .are_groups = true,
            .remedy = "then chance looks significant. Give --within",
            .unnamed = "a label that names them"};
}

std::string describe_repeated_pairs(const DifferenceOptions& options, const Collection& collection,
                                    const std::vector<std::string>& pairs)
{
    const std::vector<std::string>& pair = find_label(collection.labels, options.pair_by).values;
    std::set<std::string> repeated;
    for (const auto& [label, value] : {std::pair(options.from_label, options.from_value),
                                       std::pair(options.to_label, options.to_value)}) {
        const std::vector<std::string>& side = find_label(collection.labels, label).values;
        std::set<std::string> seen;
        for (std::size_t i = 0; i < collection.size(); ++i)
            if (side[i] == value && !seen.insert(pair[i]).second)
                repeated.insert(pair[i]);
    }
    std::vector<std::size_t> found;
    for (std::size_t k = 0; k < pairs.size(); ++k)
        if (repeated.contains(pairs[k]))
            found.push_back(k);
    if (found.empty())
        return {};
    return join(", of which ", found.size(), " (", options.pair_by, " ", list_names(pairs, found),
                ") ", found.size() == 1 ? "has" : "have",
                " several meshes on a side, which count once, by their mean");
}

std::optional<std::string> doubt_about_members(const DifferenceOptions& options,
                                               const Collection& collection, bool is_tested)
{
    const std::vector<std::string>& from = find_label(collection.labels, options.from_label).values;
    const std::vector<std::string>& to = find_label(collection.labels, options.to_label).values;
    std::vector<std::size_t> members;
    std::vector<double> side;
    for (std::size_t i = 0; i < collection.size(); ++i)
        if (from[i] == options.from_value || to[i] == options.to_value) {
            members.push_back(i);
            side.push_back(from[i] == options.from_value ? 0.0 : 1.0);
        }
    const Collection compared = subset(collection, members);
    const RepetitionQuestion rows{
        .covariates =
            Eigen::Map<const Eigen::VectorXd>(side.data(), static_cast<Eigen::Index>(side.size())),
        .columns = {options.from_label, options.to_label},
        .are_groups = true,
        .remedy =
            is_tested
                ? "then chance looks significant. Take one mesh, or the mean, of each"
                : "then those with more meshes weigh more. Take one mesh, or the mean, of each",
        .unnamed = "set",
        .is_of_means = !is_tested};
    if (auto doubt = doubt_about_rows(compared, rows))
        return doubt;
    const ShapeSpace space = make_space(compared, {.scale = options.scale});
    return doubt_about_close_rows(compared, rows, centred_inner_products(encode(space, compared)));
}

} // namespace shape::tools
