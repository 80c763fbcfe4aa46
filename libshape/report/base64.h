// SPDX-License-Identifier: MIT

#pragma once

#include <string>
#include <string_view>

namespace shape::internal {

/// Bytes as text (RFC 4648, section 4), padded with `=`.
[[nodiscard]] std::string base64(std::string_view bytes);

} // namespace shape::internal
