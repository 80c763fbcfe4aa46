// SPDX-License-Identifier: MIT

#pragma once

#include <cstddef>
#include <cstdint>

namespace shape::internal {

/// The checksum of HDF5's filter fletcher32, which follows the bytes of a chunk: the sums of its
/// 16-bit words and of those sums, modulo 65535. Several times as fast as HDF5's own loop, same value.
[[nodiscard]] std::uint32_t fletcher32(const unsigned char* bytes, std::size_t count);

} // namespace shape::internal
