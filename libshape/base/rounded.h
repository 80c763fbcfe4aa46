// SPDX-License-Identifier: MIT

#pragma once

#include <sstream>
#include <string>

namespace shape::internal {

/// The number to three significant digits, as join() prints it.
[[nodiscard]] inline std::string rounded(double value)
{
    std::ostringstream out;
    out.imbue(std::locale::classic());
    out.precision(3);
    out << value;
    return out.str();
}

} // namespace shape::internal
