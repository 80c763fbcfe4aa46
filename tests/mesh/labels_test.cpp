// SPDX-License-Identifier: MIT

#include "libshape/mesh/labels.h"

#include <gtest/gtest.h>

#include "libshape/base/error.h"

namespace shape {
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

} // namespace
} // namespace shape
