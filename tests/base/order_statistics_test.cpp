// SPDX-License-Identifier: MIT

#include "libshape/base/order_statistics.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "libshape/base/random.h"

namespace shape::internal {
namespace {

TEST(OrderStatistics, MedianIsTheMiddleOrTheMeanOfTwo)
{
    EXPECT_EQ(median({3.0}), 3.0);
    EXPECT_EQ(median({5.0, 1.0, 3.0}), 3.0);
    EXPECT_EQ(median({5.0, 1.0, 3.0, 4.0}), 3.5);
}

TEST(OrderStatistics, QuantilesAreThoseOfTheSortedValues)
{
    Random random(7);
    for (const std::size_t count : {1U, 2U, 3U, 10U, 99U, 100U, 1001U}) {
        std::vector<double> values(count);
        for (double& value : values)
            value = std::floor(random.uniform(0.0, 20.0)); // many equal ones
        std::vector<double> sorted = values;
        std::sort(sorted.begin(), sorted.end());
        const std::vector<double> shares{0.0, 0.5, 0.5, 0.99, 0.999, 1.0};
        const std::vector<double> found = quantiles_of(values, {0.0, 0.5, 0.5, 0.99, 0.999, 1.0});
        ASSERT_EQ(found.size(), shares.size());
        for (std::size_t i = 0; i < shares.size(); ++i) {
            const auto holds = [&](double value) { // this many are not above it
                return static_cast<double>(std::upper_bound(sorted.begin(), sorted.end(), value) -
                                           sorted.begin()) >=
                       shares[i] * static_cast<double>(count);
            };
            EXPECT_TRUE(holds(found[i]));
            const auto next = std::lower_bound(sorted.begin(), sorted.end(), found[i]);
            ASSERT_NE(next, sorted.end());
            EXPECT_EQ(*next, found[i]);
            if (next != sorted.begin()) { // and no smaller value will do
                EXPECT_FALSE(holds(*(next - 1)));
            }
            EXPECT_EQ(quantile_of(values, shares[i]), found[i]);
        }
    }
    EXPECT_EQ(quantiles_of({}, {0.5, 0.9}), (std::vector<double>{0.0, 0.0}));
}

} // namespace
} // namespace shape::internal
