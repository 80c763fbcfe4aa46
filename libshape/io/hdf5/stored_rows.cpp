// SPDX-License-Identifier: MIT

#include "libshape/io/hdf5/stored_rows.h"

#include <fcntl.h>
#include <hdf5.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cmath>
#include <cstring>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/threads.h"
#include "libshape/base/to_size.h"
#include "libshape/base/vectorised.h"
#include "libshape/io/hdf5/fletcher32.h"

namespace shape::internal {
namespace {

using Eigen::Index;

/// An array that is not filled before it is used.
class Bytes
{
public:
    Bytes() = default;
    explicit Bytes(std::size_t size)
        : bytes_(std::make_unique_for_overwrite<unsigned char[]>(size)), size_(size)
    {
    }
    [[nodiscard]] unsigned char* data() { return bytes_.get(); }
    [[nodiscard]] const unsigned char* data() const { return bytes_.get(); }
    [[nodiscard]] std::size_t size() const { return size_; }
    void shorten(std::size_t size) { size_ = size; }

private:
    std::unique_ptr<unsigned char[]> bytes_;
    std::size_t size_ = 0;
};

Index parts(Index extent, Index chunk)
{
    return (extent + chunk - 1) / chunk;
}

/// Size and time of the last change: a file that is replaced as a whole keeps both.
struct Version
{
    std::int64_t size, seconds, nanoseconds;
    bool operator==(const Version&) const = default;
};

std::uint32_t little_endian(const unsigned char* bytes)
{
    std::uint32_t value = 0;
    for (int i = 3; i >= 0; --i)
        value = value << 8 | bytes[i];
    return value;
}

/// Byte k of every number stood together; now they stand number by number.
Bytes unshuffled(const Bytes& from)
{
    constexpr std::size_t width = sizeof(double);
    const std::size_t count = from.size() / width;
    Bytes to(from.size());
    for (std::size_t k = 0; k < width; ++k)
        for (std::size_t i = 0; i < count; ++i)
            to.data()[i * width + k] = from.data()[k * count + i];
    return to;
}

/// Whether no number is infinite or NaN: 0 x_i is 0 then, else NaN, and so
///
///     0 x_0 + 0 x_1 + .. = 0.
///
/// sums[k] holds that of x_k, x_8+k, ..: the plain loop leaves at the first number that is not finite,
/// or adds to one sum, whose order the compiler must keep; both take a number at a time, eight sums fill
/// two to four registers. Without branches this is a small part of reading the numbers.
SHAPE_VECTORISED bool are_finite(const double* numbers, std::size_t count)
{
    double sums[8] = {};
    const std::size_t whole = count / 8 * 8;
    for (std::size_t i = 0; i < whole; i += 8)
        for (std::size_t k = 0; k < 8; ++k)
            sums[k] += 0.0 * numbers[i + k];
    for (std::size_t i = whole; i < count; ++i)
        sums[0] += 0.0 * numbers[i];
    for (std::size_t k = 1; k < 8; ++k)
        sums[0] += sums[k];
    return sums[0] == 0.0;
}

} // namespace

struct StoredRows::State
{
    ChunkTable table;
    int descriptor = -1;
    Version version{};
    /// Chunks whose checksum was right; the file has not changed since.
    mutable std::vector<std::atomic<bool>> is_verified;
    mutable std::vector<std::atomic<bool>> is_finite; ///< Rows.

    explicit State(ChunkTable chunks)
        : table(std::move(chunks)),
          is_verified(table.chunks.size()),
          is_finite(to_size(table.extents[0]))
    {
        descriptor = ::open(table.file.c_str(), O_RDONLY | O_CLOEXEC);
        if (descriptor < 0)
            fail(std::strerror(errno));
        version = now();
        (void)::posix_fadvise(descriptor, 0, 0, POSIX_FADV_SEQUENTIAL);
    }
    ~State() { ::close(descriptor); }
    State(const State&) = delete;
    State& operator=(const State&) = delete;

    [[noreturn]] void fail(const std::string& cause) const
    {
        throw FileError(join("cannot read ", table.file, ": ", cause));
    }

    [[nodiscard]] Version now() const
    {
        struct stat status = {};
        if (::fstat(descriptor, &status) != 0)
            fail(std::strerror(errno));
        return {status.st_size, status.st_mtim.tv_sec, status.st_mtim.tv_nsec};
    }

    void check_unchanged() const
    {
        if (now() != version)
            fail("it changed while it was read; leave it alone and start again");
    }

    [[noreturn]] void fail_chunk(Index first, const std::string& rule) const
    {
        check_unchanged();
        const Index last = std::min(first + table.chunk_extents[0], table.extents[0]) - 1;
        throw InvalidInput(join(
            table.file, ": ", table.dataset, ": the stored values of ",
            first == last ? join("row ", first) : join("rows ", first, " to ", last), " ", rule));
    }

    [[nodiscard]] Index across() const { return parts(table.extents[1], table.chunk_extents[1]); }
    [[nodiscard]] Index deep() const { return parts(table.extents[2], table.chunk_extents[2]); }
    [[nodiscard]] std::size_t chunk_bytes() const
    {
        return sizeof(double) *
               to_size(table.chunk_extents[0] * table.chunk_extents[1] * table.chunk_extents[2]);
    }

    [[nodiscard]] Bytes read(const ChunkTable::Chunk& chunk) const
    {
        Bytes bytes(chunk.size);
        std::size_t done = 0;
        while (done < bytes.size()) {
            const ssize_t got = ::pread(descriptor, bytes.data() + done, bytes.size() - done,
                                        static_cast<off_t>(chunk.offset + done));
            if (got < 0 && errno == EINTR)
                continue;
            if (got < 0)
                fail(std::strerror(errno));
            if (got == 0)
                fail("it ends before its values do; it is truncated, or became shorter meanwhile");
            done += to_size(got);
        }
        return bytes;
    }

    /// Undoes the filters, the last one first; leaves exactly the numbers of a chunk.
    [[nodiscard]] Bytes unpacked(std::size_t number, Index first_row, Bytes bytes) const
    {
        const ChunkTable::Chunk& chunk = table.chunks[number];
        for (std::size_t f = table.filters.size(); f-- > 0;) {
            const bool is_skipped = (chunk.skipped >> f & 1U) != 0;
            if (table.filters[f] == H5Z_FILTER_FLETCHER32) {
                if (is_skipped || bytes.size() < 4)
                    fail_chunk(first_row, "have no checksum");
                const std::size_t size = bytes.size() - 4;
                if (!is_verified[number] &&
                    fletcher32(bytes.data(), size) != little_endian(bytes.data() + size))
                    fail_chunk(first_row, "are damaged: their checksum is another");
                is_verified[number] = true;
                bytes.shorten(size);
            } else if (table.filters[f] == H5Z_FILTER_DEFLATE && !is_skipped) {
                Bytes whole(chunk_bytes());
                uLongf size = whole.size();
                if (uncompress(whole.data(), &size, bytes.data(), bytes.size()) != Z_OK ||
                    size != whole.size())
                    fail_chunk(first_row, "cannot be unpacked");
                bytes = std::move(whole);
            } else if (table.filters[f] == H5Z_FILTER_SHUFFLE && !is_skipped) {
                bytes = unshuffled(bytes);
            }
        }
        if (bytes.size() != chunk_bytes())
            fail_chunk(first_row, join("take ", bytes.size(), " bytes, must take ", chunk_bytes()));
        return bytes;
    }
};

/// The chunks of some rows.
class StoredRows::Fetched
{
public:
    std::vector<Index> rows;
    struct Piece
    {
        std::size_t chunk; ///< Number in the table.
        Bytes bytes;
    };
    std::vector<Piece> pieces;
};

StoredRows::StoredRows(ChunkTable table) : state_(std::make_shared<const State>(std::move(table)))
{
}

Index StoredRows::count() const
{
    return state_->table.extents[0];
}

Index StoredRows::size() const
{
    return state_->table.extents[1] * state_->table.extents[2];
}

std::uint64_t StoredRows::stored_bytes() const
{
    std::uint64_t sum = 0;
    for (const ChunkTable::Chunk& chunk : state_->table.chunks)
        sum += chunk.size;
    return sum;
}

void StoredRows::check_unchanged() const
{
    state_->check_unchanged();
}

std::shared_ptr<StoredRows::Fetched> StoredRows::fetch(std::vector<Index> rows) const
{
    const ChunkTable& table = state_->table;
    const Index in_a_slab = state_->across() * state_->deep();
    const auto falling = std::ranges::is_sorted_until(rows);
    if (falling != rows.end())
        throw InvalidInput(join("rows[", falling - rows.begin(), "] of ", table.dataset, " is ",
                                *falling, ", must not be below the one before"));
    auto fetched = std::make_shared<Fetched>();
    Index slab = -1;
    for (const Index row : rows) {
        if (row / table.chunk_extents[0] == slab)
            continue;
        slab = row / table.chunk_extents[0];
        for (Index c = slab * in_a_slab; c < (slab + 1) * in_a_slab; ++c) {
            fetched->pieces.push_back({to_size(c), state_->read(table.chunks[to_size(c)])});
        }
    }
    fetched->rows = std::move(rows);
    state_->check_unchanged();
    return fetched;
}

void StoredRows::unpack(Fetched& fetched, const std::function<double*(std::size_t i)>& row) const
{
    const ChunkTable& table = state_->table;
    const auto& chunk = table.chunk_extents;
    const Index in_a_slab = state_->across() * state_->deep();
    parallel_for(fetched.pieces.size(), 1, [&](std::size_t p, std::size_t) {
        const auto number = static_cast<Index>(fetched.pieces[p].chunk);
        const Index first = number / in_a_slab * chunk[0];
        const Index begin = number % in_a_slab / state_->deep() * chunk[1];
        const Index depth = number % state_->deep() * chunk[2];
        const Bytes bytes =
            state_->unpacked(to_size(number), first, std::move(fetched.pieces[p].bytes));
        const Index across = std::min(chunk[1], table.extents[1] - begin);
        const Index deep = std::min(chunk[2], table.extents[2] - depth);
        const auto low = std::lower_bound(fetched.rows.begin(), fetched.rows.end(), first);
        for (auto r = low; r != fetched.rows.end() && *r < first + chunk[0]; ++r) {
            double* const to = row(to_size(r - fetched.rows.begin()));
            const unsigned char* const from =
                bytes.data() + sizeof(double) * to_size((*r - first) * chunk[1] * chunk[2]);
            if (deep == chunk[2] && deep == table.extents[2]) {
                std::memcpy(to + begin * deep, from, sizeof(double) * to_size(across * deep));
            } else {
                for (Index j = 0; j < across; ++j)
                    std::memcpy(to + (begin + j) * table.extents[2] + depth,
                                from + sizeof(double) * to_size(j * chunk[2]),
                                sizeof(double) * to_size(deep));
            }
        }
    });
    parallel_for(fetched.rows.size(), 1, [&](std::size_t i, std::size_t) {
        const double* const numbers = row(i);
        if (state_->is_finite[to_size(fetched.rows[i])])
            return;
        if (are_finite(numbers, to_size(size()))) {
            state_->is_finite[to_size(fetched.rows[i])] = true;
            return;
        }
        const Index bad =
            std::find_if(numbers, numbers + size(), [](double x) { return !std::isfinite(x); }) -
            numbers;
        const std::string place =
            table.extents[2] > 1 ? join(", ", bad / table.extents[2], ", ", bad % table.extents[2])
            : table.extents[1] > 1 ? join(", ", bad)
                                   : "";
        throw InvalidInput(join(table.file, ": ", table.dataset, ": value (", fetched.rows[i],
                                place, ") is ", numbers[bad], ", must be finite"));
    });
}

} // namespace shape::internal
