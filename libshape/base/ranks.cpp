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
    require(is_power_of_two(ranks.lots), "Ranks.lots", ranks.lots, "a power of two");
    require(is_power_of_two(ranks.count) && ranks.count <= ranks.lots, "Ranks.count", ranks.count,
            join("a power of two, at most lots, ", ranks.lots));
    require(ranks.number >= 0 && ranks.number < ranks.count, "Ranks.number", ranks.number,
            join("in [0, ", ranks.count, ")"));
}

} // namespace shape
