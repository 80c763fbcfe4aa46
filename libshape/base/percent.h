// SPDX-License-Identifier: MIT

#pragma once

#include <cmath>
#include <string>

#include "libshape/base/format.h"

namespace shape::internal {

/// "12.3 %" of 0.1234.
[[nodiscard]] inline std::string percent(double share)
{
    return join(std::round(share * 1000.0) / 10.0, " %");
}

} // namespace shape::internal
