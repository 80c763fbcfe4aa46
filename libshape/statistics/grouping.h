// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace shape {

/// N observations in G groups.
struct Grouping
{
    std::vector<std::string> names; ///< G, all different.
    std::vector<int> group_of;      ///< N indices in [0, G).

    [[nodiscard]] int group_count() const { return static_cast<int>(names.size()); }
    [[nodiscard]] Eigen::Index size() const { return static_cast<Eigen::Index>(group_of.size()); }
};

/// Observations of equal value are a group; groups stand in the order of their first observation.
[[nodiscard]] Grouping group_by(const std::vector<std::string>& values);

/// All N observations in one group.
[[nodiscard]] Grouping one_group(Eigen::Index count);

/// Every one of N observations in a group of its own.
[[nodiscard]] Grouping groups_of_one(Eigen::Index count);

/// The observations of each group, ascending.
/// @throws InvalidInput if an index is not in [0, G) or a group is empty.
[[nodiscard]] std::vector<std::vector<int>> members(const Grouping& grouping);

/// N by G: 1 where the observation is in the group, else 0.
[[nodiscard]] Eigen::MatrixXd indicators(const Grouping& grouping);

/// The groups of some observations; groups that lose all of theirs are dropped.
[[nodiscard]] Grouping subset(const Grouping& grouping, const std::vector<int>& observations);

} // namespace shape
