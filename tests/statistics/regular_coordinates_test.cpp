// SPDX-License-Identifier: MIT

#include "libshape/statistics/regular_coordinates.h"

#include <gtest/gtest.h>

#include "tests/support/matrices.h"

namespace shape {
using namespace internal;
namespace {

TEST(RegularCoordinates, EndBeforeTheFirstThatAddsNoDirectionWithinTheGroups)
{
    const Grouping groups = group_by({"a", "b", "a", "b", "a", "b", "a", "b"});
    const RowMatrix sound = test::random_matrix(8, 4, 1);
    EXPECT_EQ(regular_coordinates(sound, groups), 4);

    RowMatrix dependent = sound;
    dependent.col(2) = dependent.col(0) - 2.0 * dependent.col(1);
    EXPECT_EQ(regular_coordinates(dependent, groups), 2);
    dependent.col(2) += 1e-5 * sound.col(2);
    EXPECT_EQ(regular_coordinates(dependent, groups), 4);
    dependent.col(2) = dependent.col(0) - 2.0 * dependent.col(1) + 1e-9 * sound.col(2);
    EXPECT_EQ(regular_coordinates(dependent, groups), 2);

    RowMatrix between =
        sound; // of its third coordinate the group is all there is, but for rounding
    for (int i = 0; i < 8; ++i)
        between(i, 2) = (i % 2 == 0 ? 0.1 : -0.7) + 1e-16 * i;
    EXPECT_EQ(regular_coordinates(between, groups), 2);
    RowMatrix constant = sound;
    constant.col(0).setConstant(3.0);
    EXPECT_EQ(regular_coordinates(constant, groups), 0);

    // Eight points in two groups have six degrees of freedom.
    EXPECT_EQ(regular_coordinates(test::random_matrix(8, 12, 2), groups), 6);
}

} // namespace
} // namespace shape
