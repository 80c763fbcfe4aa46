// SPDX-License-Identifier: MIT

#include "libshape/base/clean_up.h"

#include <gtest/gtest.h>

namespace shape::internal {
namespace {

TEST(CleanUp, TriesOnceMoreWhereMemoryLacked)
{
    for (const int failures : {0, 1, 5}) {
        int calls = 0;
        clean_up([&] {
            if (++calls <= failures)
                throw std::bad_alloc();
        });
        EXPECT_EQ(calls, failures == 0 ? 1 : 2);
    }
}

} // namespace
} // namespace shape::internal
