// SPDX-License-Identifier: MIT

#include "libshape/statistics/mean.h"

#include <gtest/gtest.h>

#include "libshape/base/error.h"

namespace shape {
namespace {

TEST(MeanOfRows, IsTheMeanOfEveryColumn)
{
    RowMatrix data(3, 2);
    data << 1, -2, 2, 0, 6, 5;
    EXPECT_EQ(mean_of_rows(data), Eigen::Vector2d(3, 1));
    EXPECT_EQ(mean_of_rows(data.topRows(1)), Eigen::Vector2d(1, -2));
}

TEST(MeanOfRows, RefusesNoRow)
{
    EXPECT_THROW((void)mean_of_rows(RowMatrix(0, 2)), InvalidInput);
}

} // namespace
} // namespace shape
