// SPDX-License-Identifier: MIT

#include "libshape/base/ranks.h"

#include <gtest/gtest.h>

#include "libshape/base/error.h"

namespace shape {
namespace {

TEST(Ranks, AreAPowerOfTwoOfThemWithinThePartialSums)
{
    const auto ranks = [](int number, int count, int partial_sums) {
        Ranks made;
        made.number = number;
        made.count = count;
        made.partial_sums = partial_sums;
        return made;
    };
    EXPECT_NO_THROW(check(Ranks()));
    EXPECT_NO_THROW(check(ranks(3, 4, 16)));
    EXPECT_THROW(check(ranks(0, 2, 1)), InvalidInput);
    EXPECT_THROW(check(ranks(0, 3, 16)), InvalidInput);
    EXPECT_THROW(check(ranks(0, 0, 16)), InvalidInput);
    EXPECT_THROW(check(ranks(2, 2, 16)), InvalidInput);
    EXPECT_THROW(check(ranks(-1, 2, 16)), InvalidInput);
    EXPECT_THROW(check(ranks(0, 1, 0)), InvalidInput);
    EXPECT_THROW(check(ranks(0, 1, 6)), InvalidInput);
    EXPECT_THROW(check(ranks(0, 4, 6)), InvalidInput);
}

} // namespace
} // namespace shape
