// SPDX-License-Identifier: MIT

#pragma once

#include <sstream>
#include <string>

namespace shape::internal {

/// Joins its arguments as an output stream in the classic locale prints them:
/// join("face ", 3, " has ", 1.5) == "face 3 has 1.5".
template <class... Parts>
[[nodiscard]] std::string join(const Parts&... parts)
{
    std::ostringstream out;
    out.imbue(std::locale::classic());
    (out << ... << parts);
    return out.str();
}

} // namespace shape::internal
