// SPDX-License-Identifier: MIT

#pragma once

#include <string_view>

namespace shape::tools {

/// The page as tools/explore builds it, for page_html(); empty if this program was built without it.
[[nodiscard]] std::string_view page_frame();

} // namespace shape::tools
