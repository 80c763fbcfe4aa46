// SPDX-License-Identifier: MIT

#pragma once

#include "libshape/base/error.h"
#include "libshape/base/format.h"

namespace shape::internal {

/// Measures of results hold fifth powers of lengths.
/// @param largest  Longest edge [length]. @param what  "the target".
/// @throws InvalidInput if it is not in [1e-60, 1e60].
inline void check_size(double largest, const char* what)
{
    constexpr double limit = 1e60;
    if (!(largest >= 1.0 / limit && largest <= limit))
        throw InvalidInput(join("the longest edge of ", what, " is ", largest, ", must be in [",
                                1.0 / limit, ", ", limit, "]; choose another unit"));
}

} // namespace shape::internal
