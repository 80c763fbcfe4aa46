// SPDX-License-Identifier: MIT

#pragma once

#include <cstdint>

namespace shape::internal {

/// Whether the system limits the address space or the data of this process (`ulimit -v`, `-d`).
[[nodiscard]] bool is_memory_limited();

/// Address space of this process [byte]; 0 if the system does not say.
[[nodiscard]] std::uint64_t address_space();

/// What is left of it below its limit [byte]; the largest value if there is none.
[[nodiscard]] std::uint64_t address_space_left();

} // namespace shape::internal
