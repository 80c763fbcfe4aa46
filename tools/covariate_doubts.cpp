// SPDX-License-Identifier: MIT

#include "tools/covariate_doubts.h"

#include <algorithm>
#include <cstdio>
#include <limits>

#include "libshape/base/counted.h"
#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/to_size.h"
#include "libshape/io/table_file.h"
#include "libshape/mesh/oddities.h"
#include "libshape/statistics/group_fit.h"

namespace shape::tools {
using namespace internal;

using Eigen::Index;
using Eigen::VectorXd;

namespace {

bool is_number(const std::string& text)
{
    try {
        (void)parse_number(text, "");
        return true;
    } catch (const InvalidInput&) {
        return false;
    }
}

} // namespace

std::optional<std::string> doubt_about_varying_blocks(const VectorXd& covariate,
                                                      const Grouping& blocks,
                                                      const std::string& option,
                                                      const std::string& within)
{
    const std::vector<std::vector<int>> lists = members(blocks);
    std::vector<std::size_t> varying;
    std::size_t repeated = 0; // meshes
    std::size_t lost = 0;
    for (std::size_t b = 0; b < lists.size(); ++b) {
        if (lists[b].size() < 2)
            continue;
        repeated += lists[b].size();
        const VectorXd own = covariate(lists[b]);
        if (own.minCoeff() < own.maxCoeff())
            varying.push_back(b);
        else
            lost += lists[b].size();
    }
    if (varying.empty() || 2 * lost <= repeated)
        return std::nullopt;
    return join(option, " is the same in all meshes of each block of --within ", within,
                " but for ", varying.size(), " of ", lists.size(), ": ",
                list_names(blocks.names, varying),
                varying.size() == 1 ? ", which alone determines" : ", which alone determine",
                " its slope, as that is the one within blocks. If that is a slip, correct it");
}

VectorXd slope_shares(const VectorXd& weights, const Grouping& rows, const Grouping& carriers)
{
    VectorXd row_weights = VectorXd::Zero(rows.group_count());
    std::vector<int> carrier_of(rows.names.size(), 0);
    for (std::size_t i = 0; i < rows.group_of.size(); ++i) {
        row_weights[rows.group_of[i]] += weights[static_cast<Index>(i)];
        carrier_of[to_size(rows.group_of[i])] = carriers.group_of[i];
    }
    VectorXd shares = VectorXd::Zero(carriers.group_count());
    for (Index row = 0; row < row_weights.size(); ++row)
        shares[carrier_of[to_size(row)]] += row_weights[row] * row_weights[row];
    return shares / shares.sum();
}

VectorXd shares_beyond_means(VectorXd shares, const Grouping& rows, const Grouping& means)
{
    constexpr int few = 8;
    if (rows.size() < few)
        return shares;
    const std::vector<std::vector<int>> lists = members(means);
    for (std::size_t row = 0; row < rows.group_of.size(); ++row) {
        const auto count = static_cast<double>(lists[to_size(means.group_of[row])].size());
        if (count > 1.0)
            shares[rows.group_of[row]] *= count / (count - 1.0);
    }
    return shares;
}

std::optional<std::string> doubt_about_slope(const VectorXd& covariate, const Grouping& carriers,
                                             const VectorXd& shares, const std::string& option,
                                             const std::string& within)
{
    Index first = 0;
    const double share = shares.maxCoeff(&first);
    if (!(share > determining_share))
        return std::nullopt;
    constexpr double infinity = std::numeric_limits<double>::infinity();
    double low[2] = {infinity, infinity}; // of the others, and of this
    double high[2] = {-infinity, -infinity};
    for (std::size_t i = 0; i < carriers.group_of.size(); ++i) {
        const int own = carriers.group_of[i] == first ? 1 : 0;
        low[own] = std::min(low[own], covariate[static_cast<Index>(i)]);
        high[own] = std::max(high[own], covariate[static_cast<Index>(i)]);
    }
    const auto range = [&](int own) {
        return low[own] == high[own] ? join("at ", low[own])
                                     : join("from ", low[own], " to ", high[own]);
    };
    char percent[40];
    std::snprintf(percent, sizeof percent, "%.3g", 100.0 * share);
    return join(option, ": ", within.empty() ? "" : join(within, " "),
                carriers.names[to_size(first)], " alone determines the slope (", percent,
                " % of what it rests on), ", range(1), " where the others lie ", range(0),
                ": what is found is of that one. If that is a slip, correct it; else see what is "
                "found without it");
}

std::optional<std::string> doubt_about_numeric_groups(const Grouping& groups, const std::string& by)
{
    constexpr int few = 10; // may be a design
    if (groups.group_count() < few || groups.size() >= 2 * groups.group_count() ||
        !std::ranges::all_of(groups.names, is_number))
        return std::nullopt;
    return join(
        "--by ", by, ": its ", groups.group_count(), " values in ", groups.size(),
        " meshes are numbers, nearly all different, and each is a group here; shape regress "
        "--on ",
        by, " takes them as numbers");
}

} // namespace shape::tools
