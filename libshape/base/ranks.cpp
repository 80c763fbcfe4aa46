// SPDX-License-Identifier: MIT

#include "libshape/base/ranks.h"

#include "libshape/base/format.h"
#include "libshape/base/require.h"

namespace shape {
using namespace internal;

void check(const Ranks& ranks)
{
    const auto is_power_of_two = [](int number) {
        return number > 0 && (number & (number - 1)) == 0;
    };
    require(is_power_of_two(ranks.partial_sums), "Ranks.partial_sums", ranks.partial_sums,
            "a power of two");
    require(is_power_of_two(ranks.count) && ranks.count <= ranks.partial_sums, "Ranks.count",
            ranks.count, join("a power of two, at most partial_sums, ", ranks.partial_sums));
    require(ranks.number >= 0 && ranks.number < ranks.count, "Ranks.number", ranks.number,
            join("in [0, ", ranks.count, ")"));
}

} // namespace shape
