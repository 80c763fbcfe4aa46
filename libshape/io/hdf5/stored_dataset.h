// SPDX-License-Identifier: MIT

#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "libshape/io/hdf5/extents.h"

namespace shape::internal {

/// A dataset as its file declares it, as plain values.
struct StoredDataset
{
    enum class Type
    {
        Float64,
        Int32,
        FixedString,
        Other
    };
    enum class Layout
    {
        Compact, ///< In the header.
        Contiguous,
        Chunked,
        Other
    };
    /// Of the bytes in FileContent::values.
    struct Range
    {
        std::uint64_t begin = 0;
        std::uint64_t size = 0;
    };

    Type type = Type::Other;
    std::uint64_t value_size = 0; ///< [byte]
    int rank = 0;                 ///< -1: neither a single value nor an array.
    Extents extents{};            ///< If the rank is at most 3.
    Layout layout = Layout::Other;
    bool is_external = false;   ///< Some values are in other files.
    Extents chunk{};            ///< Extents of a chunk; empty if the values are not in chunks.
    std::vector<int> filters{}; ///< HDF5's numbers, in the order of writing.
    std::uint64_t offset = no_offset; ///< Of contiguous values in the file [byte].
    /// Of doubles in chunks: a ChunkTable::Chunk for each. Of contiguous doubles: nothing. Else the values,
    /// in row-major order: double, int, or strings of value_size bytes.
    Range values{};
    std::string refusal{}; ///< Why the values could not be had, if they could not.

    static constexpr std::uint64_t no_offset = ~std::uint64_t{0};

    [[nodiscard]] bool is_compressed() const;
    [[nodiscard]] Eigen::Index count() const;       ///< Of values.
    [[nodiscard]] Eigen::Index chunk_count() const; ///< If the values are in chunks.
};

/// The rule that the declaration breaks, for messages: how values may be stored, and that the file has
/// room for them. Empty if none; then count() and chunk_count() do not overflow.
/// @param file_size  [byte]
[[nodiscard]] std::string broken_rule(const StoredDataset& dataset, std::uint64_t file_size);

/// "3 by any": for messages.
[[nodiscard]] std::string print_extents(const Extents& extents);

/// Of one dataset in memory [byte].
inline constexpr std::uint64_t largest_array = std::uint64_t{8} << 30;

} // namespace shape::internal
