// SPDX-License-Identifier: MIT

#include "libshape/base/pool.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <vector>

#include "libshape/base/threads.h"

namespace shape {
using namespace internal;
namespace {

TEST(Pool, MakesAsManyAsAreBorrowedAtOnceAndLendsThemAgain)
{
    int made = 0;
    Pool<int> pool([&] { return std::make_unique<int>(made++); });
    {
        const auto first = pool.borrow();
        const auto second = pool.borrow();
        EXPECT_EQ(*first, 0);
        EXPECT_EQ(*second, 1);
    }
    for (int i = 0; i < 3; ++i)
        EXPECT_LT(*pool.borrow(), 2);
    EXPECT_EQ(made, 2);
}

TEST(Pool, LendsNothingTwiceAtOnce)
{
    Pool<int> pool;
    std::vector<char> alone(1000, 0);
    parallel_for(alone.size(), 1, [&](std::size_t i, std::size_t) {
        const auto item = pool.borrow();
        const int before = (*item)++;
        alone[i] = *item == before + 1;
        --*item;
    });
    EXPECT_EQ(std::count(alone.begin(), alone.end(), 1), 1000);
}

} // namespace
} // namespace shape
