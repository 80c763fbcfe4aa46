// SPDX-License-Identifier: MIT

#include "libshape/linalg/strips.h"

#include <gtest/gtest.h>

#include <vector>

#include "tests/support/thread_scope.h"

namespace shape {
using namespace internal;
namespace {

using Eigen::Index;

TEST(Strips, CoverAllOnceWhateverTheThreads)
{
    for (const int threads : {1, 3}) {
        const test::ThreadScope scope(threads);
        std::vector<Index> counts(4, 0);
        for_strips(32, 10, [&](Index first, Index count) {
            EXPECT_EQ(first % 10, 0);
            counts[static_cast<std::size_t>(first / 10)] += count;
        });
        EXPECT_EQ(counts, (std::vector<Index>{10, 10, 10, 2}));
    }
    for_strips(0, 10, [](Index, Index) { FAIL() << "there is nothing to work on"; });
}

} // namespace
} // namespace shape
