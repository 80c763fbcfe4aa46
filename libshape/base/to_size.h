// SPDX-License-Identifier: MIT

#pragma once

#include <concepts>
#include <cstddef>

namespace shape::internal {

/// A number >= 0, such as an index or a count, as the containers of the standard library take it;
/// Eigen and Topology count by signed numbers.
[[nodiscard]] constexpr std::size_t to_size(std::integral auto number)
{
    return static_cast<std::size_t>(number);
}

} // namespace shape::internal
