// SPDX-License-Identifier: MIT

#include "libshape/mesh/labels.h"

#include <gtest/gtest.h>

#include "libshape/base/error.h"
#include "libshape/mesh/joined_labels.h"

namespace shape {
using namespace internal;
namespace {

/// The message of find_label() for a name that is not there.
std::string message_for(const Labels& labels)
{
    try {
        (void)find_label(labels, "age");
    } catch (const InvalidInput& error) {
        return error.what();
    }
    return "nothing was thrown";
}

TEST(FindLabel, GivesTheColumnOfThatName)
{
    const Labels labels{{"sex", {"f", "m"}}, {"subject", {"s1", "s2"}}};
    EXPECT_EQ(&find_label(labels, "subject"), &labels[1]);
    EXPECT_EQ(find_label(labels, "sex").values[1], "m");
}

TEST(FindLabel, ListsTheColumnsThereAreWhenItHasNone)
{
    EXPECT_EQ(message_for({{"sex", {}}, {"subject", {}}}),
              "no label column 'age'; the collection has sex, subject");
    EXPECT_EQ(message_for({}), "no label column 'age'; the collection has no labels");
}

TEST(TakeLabels, FillsThoseOfTheSameNamesAndSaysWhichWereOthers)
{
    Labels labels{{"sex", {"f", "", "m"}}};
    const std::vector<ReplacedLabel> replaced = take_labels(
        labels, {"a", "b", "c"}, {{"sex", {"f", "", "f", "f"}}, {"age", {"7", "8", "9", ""}}},
        {"c", "a", "b", "new"});
    ASSERT_EQ(labels.size(), 2u);
    EXPECT_EQ(labels[0].values,
              (std::vector<std::string>{"f", "f", "f"})); // nothing takes none away
    EXPECT_EQ(labels[1].values, (std::vector<std::string>{"8", "9", "7"}));
    ASSERT_EQ(replaced.size(), 1u);
    EXPECT_EQ(replaced[0].mesh, "c");
    EXPECT_EQ(replaced[0].label, "sex");
    EXPECT_EQ(replaced[0].before, "m");
    EXPECT_EQ(replaced[0].now, "f");
}

} // namespace
} // namespace shape
