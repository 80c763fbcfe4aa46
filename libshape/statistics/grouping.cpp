// SPDX-License-Identifier: MIT

#include "libshape/statistics/grouping.h"

#include <map>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/to_size.h"

namespace shape {
using namespace internal;

Grouping group_by(const std::vector<std::string>& values)
{
    Grouping grouping;
    std::map<std::string, int> group_of;
    for (const std::string& value : values) {
        const auto [entry, is_new] = group_of.try_emplace(value, grouping.group_count());
        if (is_new)
            grouping.names.push_back(value);
        grouping.group_of.push_back(entry->second);
    }
    return grouping;
}

Grouping one_group(Eigen::Index count)
{
    return group_by(std::vector<std::string>(to_size(count), "all"));
}

Grouping groups_of_one(Eigen::Index count)
{
    Grouping grouping;
    for (int i = 0; i < count; ++i) {
        grouping.names.push_back(std::to_string(i));
        grouping.group_of.push_back(i);
    }
    return grouping;
}

std::vector<std::vector<int>> members(const Grouping& grouping)
{
    std::vector<std::vector<int>> lists(grouping.names.size());
    for (std::size_t i = 0; i < grouping.group_of.size(); ++i) {
        const int group = grouping.group_of[i];
        if (group < 0 || group >= grouping.group_count())
            throw InvalidInput(join("grouping: observation ", i, " is in group ", group,
                                    ", must be in [0, ", grouping.group_count(), ")"));
        lists[to_size(group)].push_back(static_cast<int>(i));
    }
    for (std::size_t g = 0; g < lists.size(); ++g)
        if (lists[g].empty())
            throw InvalidInput(join("grouping: group '", grouping.names[g], "' is empty"));
    return lists;
}

Eigen::MatrixXd indicators(const Grouping& grouping)
{
    Eigen::MatrixXd result = Eigen::MatrixXd::Zero(grouping.size(), grouping.group_count());
    const std::vector<std::vector<int>> lists = members(grouping);
    for (std::size_t g = 0; g < lists.size(); ++g)
        result(lists[g], static_cast<Eigen::Index>(g)).setOnes();
    return result;
}

Grouping subset(const Grouping& grouping, const std::vector<int>& observations)
{
    std::vector<std::string> values;
    for (const int i : observations)
        values.push_back(grouping.names.at(to_size(grouping.group_of.at(to_size(i)))));
    return group_by(values);
}

} // namespace shape
