// SPDX-License-Identifier: MIT

#include "libshape/base/ranks.h"

#include "libshape/base/format.h"
#include "libshape/base/require.h"

namespace shape {
using namespace internal;

void check(const Ranks& ranks)
{
    require_at_least(1, ranks.lots, "Ranks.lots");
    const bool is_power_of_two = ranks.count > 0 && (ranks.count & (ranks.count - 1)) == 0;
    require(is_power_of_two && ranks.count <= ranks.lots, "Ranks.count", ranks.count,
            join("a power of two, at most lots, ", ranks.lots));
    require(ranks.number >= 0 && ranks.number < ranks.count, "Ranks.number", ranks.number,
            join("in [0, ", ranks.count, ")"));
}

} // namespace shape
