// SPDX-License-Identifier: MIT

#include "libshape/statistics/grouping.h"

#include <gtest/gtest.h>

#include "libshape/base/error.h"

namespace shape {
namespace {

using Lists = std::vector<std::vector<int>>;

TEST(Grouping, HasGroupsInTheOrderOfTheirFirstObservation)
{
    const Grouping grouping = group_by({"b", "a", "b", "c", "a"});
    EXPECT_EQ(grouping.names, (std::vector<std::string>{"b", "a", "c"}));
    EXPECT_EQ(grouping.group_of, (std::vector<int>{0, 1, 0, 2, 1}));
    EXPECT_EQ(members(grouping), (Lists{{0, 2}, {1, 4}, {3}}));
    const Eigen::MatrixXd expected{{1, 0, 0}, {0, 1, 0}, {1, 0, 0}, {0, 0, 1}, {0, 1, 0}};
    EXPECT_EQ(indicators(grouping), expected);
}

TEST(Grouping, OfOneGroupOrOfSingles)
{
    EXPECT_EQ(members(one_group(3)), (Lists{{0, 1, 2}}));
    EXPECT_EQ(members(groups_of_one(3)), (Lists{{0}, {1}, {2}}));
}

TEST(Grouping, OfASubsetDropsGroupsWithoutMembers)
{
    const Grouping grouping = subset(group_by({"b", "a", "b", "c", "a"}), {3, 1, 4});
    EXPECT_EQ(grouping.names, (std::vector<std::string>{"c", "a"}));
    EXPECT_EQ(grouping.group_of, (std::vector<int>{0, 1, 1}));
}

TEST(Grouping, RefusesIndicesOutOfRangeAndEmptyGroups)
{
    EXPECT_THROW((void)members({{"a", "b"}, {0, 2}}), InvalidInput);
    EXPECT_THROW((void)members({{"a", "b"}, {0, -1}}), InvalidInput);
    EXPECT_THROW((void)members({{"a", "b"}, {0, 0}}), InvalidInput);
}

} // namespace
} // namespace shape
