// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace shape::internal {

/// Where a dataset of doubles in chunks has its bytes, as the file's index says.
struct ChunkTable
{
    struct Chunk
    {
        std::uint64_t offset; ///< In the file [byte].
        std::uint64_t size;   ///< As stored [byte].
        std::uint64_t
            skipped; ///< Bit i: filter i was not applied. As wide as the others: no padding, equal bytes.
    };
    std::string file;    ///< Path, for reading and for messages.
    std::string dataset; ///< For messages.
    std::array<Eigen::Index, 3> extents{1, 1, 1};
    std::array<Eigen::Index, 3> chunk_extents{1, 1, 1};
    std::vector<int>
        filters{}; ///< HDF5's numbers, in the order of writing; fletcher32 is the last.
    std::vector<Chunk> chunks{}; ///< In row-major order of their places.
};

[[nodiscard]] constexpr bool lies_in_file(const ChunkTable::Chunk& chunk, std::uint64_t file_size)
{
    return chunk.offset <= file_size && chunk.size <= file_size - chunk.offset;
}

/// Rows of a dataset, read past HDF5: bytes are fetched, checked against their checksum the first time, and
/// unpacked here, chunk by chunk. So HDF5 meets no data of a stranger, and memory is that of the rows asked for.
/// Every member may be called from several threads at once.
class StoredRows
{
public:
    /// Opens the file once more.
    /// @throws FileError if it cannot be read.
    explicit StoredRows(ChunkTable table);

    [[nodiscard]] Eigen::Index count() const;         ///< Rows.
    [[nodiscard]] Eigen::Index size() const;          ///< Numbers of a row.
    [[nodiscard]] std::uint64_t stored_bytes() const; ///< Of all chunks.

    /// Bytes as they stand in the file.
    class Fetched;

    /// Reads the chunks that hold these rows; does no more than to wait for the disk.
    /// @param rows  Ascending.
    /// @throws InvalidInput if they are not.
    /// @throws FileError if the file cannot be read or has changed since it was opened.
    [[nodiscard]] std::shared_ptr<Fetched> fetch(std::vector<Eigen::Index> rows) const;

    /// Checks and unpacks them on all threads; uses the bytes up.
    /// @param row  Where the numbers of the i-th row go.
    /// @throws InvalidInput naming file, dataset and rows if a chunk is damaged or a number is not
    ///     finite.
    void unpack(Fetched& fetched, const std::function<double*(std::size_t i)>& row) const;

    /// @throws FileError if the file was written to since it was opened.
    void check_unchanged() const;

private:
    struct State;
    std::shared_ptr<const State> state_;
};

} // namespace shape::internal
