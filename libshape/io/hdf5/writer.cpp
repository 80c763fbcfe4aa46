// SPDX-License-Identifier: MIT

#include "libshape/io/hdf5/writer.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <cstdint>
#include <cstring>
#include <functional>
#include <new>
#include <numeric>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/memory_limit.h"
#include "libshape/base/to_size.h"
#include "libshape/io/file/line_reader.h"
#include "libshape/io/file/output_file.h"
#include "libshape/io/hdf5/file_driver.h"
#include "libshape/io/hdf5/handles.h"

namespace shape::internal {
namespace {

constexpr std::size_t chunk_size = 1 << 20; // [byte]

/// Fixed-length text, padded with NUL: unlike the heap of variable-length strings it has checksums. UTF-8,
/// but tagged as ASCII where it is no more than that, for Octave reads no other.
Id make_string_type(std::size_t size, bool is_ascii, bool plain)
{
    Id type(H5Tcopy(H5T_C_S1), H5Tclose);
    checked(H5Tset_size(type, size));
    checked(H5Tset_strpad(type, plain ? H5T_STR_NULLTERM : H5T_STR_NULLPAD));
    checked(H5Tset_cset(type, is_ascii ? H5T_CSET_ASCII : H5T_CSET_UTF8));
    return type;
}

/// Values as HDF5 takes them.
struct Encoded
{
    Id type;                ///< On file.
    Id memory_type;         ///< In memory.
    const void* values;     ///< The caller's numbers.
    std::size_t value_size; ///< [byte]
    std::size_t count;
    std::string strings; ///< Or strings side by side, padded to equal size.
    Hdf5Rows rows = {};  ///< Or what makes them.

    [[nodiscard]] const void* data() const { return strings.empty() ? values : strings.data(); }
    [[nodiscard]] std::size_t size() const { return count * value_size; }
};

Encoded encode(std::span<const double> values, const std::string&, bool)
{
    return {{H5Tcopy(H5T_IEEE_F64LE), H5Tclose},
            {H5Tcopy(H5T_NATIVE_DOUBLE), H5Tclose},
            values.data(),
            sizeof(double),
            values.size(),
            {}};
}

Encoded encode(std::span<const float> values, const std::string&, bool)
{
    return {{H5Tcopy(H5T_IEEE_F32LE), H5Tclose},
            {H5Tcopy(H5T_NATIVE_FLOAT), H5Tclose},
            values.data(),
            sizeof(float),
            values.size(),
            {}};
}

Encoded encode(std::span<const int> values, const std::string&, bool)
{
    return {{H5Tcopy(H5T_STD_I32LE), H5Tclose},
            {H5Tcopy(H5T_NATIVE_INT), H5Tclose},
            values.data(),
            sizeof(int),
            values.size(),
            {}};
}

Encoded encode(std::span<const std::int64_t> values, const std::string&, bool)
{
    return {{H5Tcopy(H5T_STD_I64LE), H5Tclose},
            {H5Tcopy(H5T_NATIVE_INT64), H5Tclose},
            values.data(),
            sizeof(std::int64_t),
            values.size(),
            {}};
}

Encoded encode(std::span<const std::string> values, const std::string& name, bool plain)
{
    std::size_t size = 1;
    for (const std::string& text : values) {
        if (text.find('\0') != std::string::npos || !is_utf8(text) || text.size() > longest_string)
            throw InvalidInput(join(name, ": ", in_quotes(text),
                                    " must be UTF-8 without NUL, at most ", longest_string,
                                    " bytes"));
        size = std::max(size, text.size() + (plain ? 1 : 0));
    }
    std::string packed;
    packed.reserve(size * values.size());
    for (const std::string& text : values) {
        packed += text;
        packed.append(size - text.size(), '\0');
    }
    const bool is_ascii = std::ranges::all_of(packed, [](char c) { return (c & 0x80) == 0; });
    return {make_string_type(size, is_ascii, plain),
            make_string_type(size, is_ascii, plain),
            nullptr,
            size,
            values.size(),
            std::move(packed)};
}

Encoded encode(const Hdf5Rows& rows, const std::string& name, bool plain)
{
    Encoded encoded = encode(std::span<const double>(), name, plain);
    encoded.rows = rows;
    return encoded;
}

std::size_t product(std::span<const Eigen::Index> extents)
{
    return to_size(
        std::accumulate(extents.begin(), extents.end(), Eigen::Index{1}, std::multiplies()));
}

Encoded encode(const Hdf5Dataset& dataset, bool plain)
{
    Encoded encoded = std::visit(
        [&](const auto& values) { return encode(values, dataset.name, plain); }, dataset.values);
    if (encoded.rows)
        encoded.count = product(dataset.extents);
    return encoded;
}

Encoded encode(const std::string& name, const Hdf5Value& value, bool plain)
{
    return std::visit([&](const auto& v) { return encode(std::span(&v, 1), name, plain); }, value);
}

/// Objects without time stamps, so that equal contents give equal bytes.
Id make_creation_list(hid_t kind)
{
    Id list(H5Pcreate(kind), H5Pclose);
    checked(H5Pset_obj_track_times(list, false));
    return list;
}

/// Chunks of at most about 1 MiB of consecutive values. A row that needs several is cut into equal
/// ones; of smaller rows a power of two stands together, so that readers who take such a number of
/// rows at a time read no chunk twice.
std::vector<hsize_t> chunk_dimensions(const Extents& extents, std::size_t value_size)
{
    std::vector<hsize_t> chunk = dimensions(extents);
    hsize_t budget = std::max<hsize_t>(chunk_size / value_size, 1);
    for (auto length = chunk.rbegin(); length != chunk.rend(); ++length) {
        const hsize_t whole = *length;
        *length = std::min(whole, budget);
        if (std::next(length) != chunk.rend()) {
            const hsize_t parts = (whole + *length - 1) / *length;
            *length = (whole + parts - 1) / parts;
        } else if (chunk.size() > 1 && *length < whole) {
            *length = std::bit_floor(*length);
        }
        budget = std::max<hsize_t>(budget / *length, 1);
    }
    return chunk;
}

/// A part of a dataset: where it is on file and in memory, and its values.
struct Block
{
    hid_t file_space;
    hid_t memory_space;
    const void* values;
    std::size_t size; ///< [byte]
};

/// A hash of numbers in words of 64 bits.
std::uint64_t hash(const void* values, std::size_t size)
{
    std::uint64_t result = size;
    for (std::size_t i = 0; i + 8 <= size; i += 8) {
        std::uint64_t word = 0;
        std::memcpy(&word, static_cast<const char*>(values) + i, 8);
        result = std::rotl(result ^ word, 29) * 0x9e3779b97f4a7c15;
    }
    return result;
}

/// Runs action(block) for a dataset's values, whole rows of about 1 MiB together at a time, until it
/// gives false. Numbers that are to be made are missing unless `make` is set.
void for_each_block(const Encoded& values, const Extents& extents, bool make,
                    const std::function<bool(const Block&)>& action)
{
    if (extents.empty()) {
        action({H5S_ALL, H5S_ALL, values.data(), values.size()});
        return;
    }
    const std::size_t row_size = product(std::span(extents).subspan(1));
    const std::vector<hsize_t> whole = dimensions(extents);
    const hsize_t step = chunk_dimensions(extents, values.value_size).front();
    const Id file_space = make_space(extents);
    std::vector<double> made;
    std::vector<hsize_t> start(whole.size(), 0);
    bool goes_on = true;
    for (; goes_on && start[0] < whole[0]; start[0] += step) {
        std::vector<hsize_t> count = whole;
        count[0] = std::min(step, whole[0] - start[0]);
        checked(H5Sselect_hyperslab(file_space, H5S_SELECT_SET, start.data(), nullptr, count.data(),
                                    nullptr));
        const Id memory_space(
            H5Screate_simple(static_cast<int>(count.size()), count.data(), nullptr), H5Sclose);
        const void* block = nullptr;
        if (!values.rows) {
            block =
                static_cast<const char*>(values.data()) + start[0] * row_size * values.value_size;
        } else if (make) {
            made.resize(count[0] * row_size);
            for (std::size_t i = 0; i < count[0]; ++i)
                values.rows(static_cast<Eigen::Index>(start[0] + i),
                            std::span(made).subspan(i * row_size, row_size));
            block = made.data();
        }
        goes_on =
            action({file_space, memory_space, block, count[0] * row_size * values.value_size});
    }
}

/// Creates the group of a dataset. Groups remember the order of their members: that of labels.
void create_group(hid_t file, const std::string& dataset, bool plain)
{
    const std::string group = dataset.substr(0, dataset.rfind('/'));
    if (group.empty() || checked(H5Lexists(file, group.c_str(), H5P_DEFAULT)) > 0)
        return;
    create_group(file, group, plain); // that of the group
    const Id list = make_creation_list(H5P_GROUP_CREATE);
    if (!plain)
        checked(H5Pset_link_creation_order(list, H5P_CRT_ORDER_TRACKED | H5P_CRT_ORDER_INDEXED));
    Id(H5Gcreate2(file, group.c_str(), H5P_DEFAULT, list, H5P_DEFAULT), H5Gclose).close();
}

/// @param hashes  Get those of the blocks that are made.
void write_dataset(hid_t file, const Hdf5Dataset& dataset, bool plain,
                   std::vector<std::uint64_t>& hashes, const NewFile& target)
{
    const Encoded values = encode(dataset, plain);
    const Id space = make_space(dataset.extents);
    const auto count = to_size(checked(H5Sget_simple_extent_npoints(space)));
    if (count != values.count || count == 0)
        throw InvalidInput(join(dataset.name, ": has ", values.count, " values, must have ", count,
                                " and at least 1"));
    create_group(file, dataset.name, plain);
    const Id creation = make_creation_list(H5P_DATASET_CREATE);
    if (plain) {
        checked(H5Pset_layout(creation, H5D_CONTIGUOUS));
    } else if (dataset.extents.empty()) {
        checked(H5Pset_layout(creation, H5D_COMPACT)); // within the checksummed header
    } else {
        const std::vector<hsize_t> chunk = chunk_dimensions(dataset.extents, values.value_size);
        checked(H5Pset_chunk(creation, static_cast<int>(chunk.size()), chunk.data()));
        if (dataset.compress) {
            constexpr unsigned level = 4; // higher ones take twice the time for a percent
            checked(H5Pset_shuffle(creation));
            checked(H5Pset_deflate(creation, level));
        }
        checked(H5Pset_fletcher32(creation));
    }
    const Id link(H5Pcreate(H5P_LINK_CREATE), H5Pclose);
    checked(H5Pset_char_encoding(link, H5T_CSET_UTF8));
    Id stored(
        H5Dcreate2(file, dataset.name.c_str(), values.type, space, link, creation, H5P_DEFAULT),
        H5Dclose);
    for_each_block(values, dataset.extents, true, [&](const Block& block) {
        if (values.rows)
            hashes.push_back(hash(block.values, block.size));
        checked(H5Dwrite(stored, values.memory_type, block.memory_space, block.file_space,
                         H5P_DEFAULT, block.values));
        return target.error == 0;
    });
    stored.close();
}

void write_attribute(hid_t place, const std::string& name, const Hdf5Value& value, bool plain)
{
    const Encoded encoded = encode(name, value, plain);
    Id attribute(
        H5Acreate2(place, name.c_str(), encoded.type, make_space({}), H5P_DEFAULT, H5P_DEFAULT),
        H5Aclose);
    checked(H5Awrite(attribute, encoded.memory_type, encoded.data()));
    attribute.close();
}

/// Makes the file; no error of the disk meets HDF5, which does not report them all.
/// @return Hashes of the blocks that were made, in their order.
std::vector<std::uint64_t> make_file(const Hdf5Content& content, NewFile& target)
{
    static std::atomic<unsigned> counter{0};
    const std::string unique = join("/dev/null/shape-", counter++); // no such file can exist
    const Id access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
    write_through(access, target);
    checked(H5Pset_libver_bounds(access, content.plain ? H5F_LIBVER_EARLIEST : H5F_LIBVER_LATEST,
                                 H5F_LIBVER_LATEST));
    Id file(H5Fcreate(unique.c_str(), H5F_ACC_TRUNC, make_creation_list(H5P_FILE_CREATE), access),
            H5Fclose);
    std::vector<std::uint64_t> hashes;
    for (const auto& [name, value] : content.attributes)
        write_attribute(file, name, value, content.plain);
    for (const Hdf5Dataset& dataset : content.datasets) {
        write_dataset(file, dataset, content.plain, hashes, target);
        if (target.error != 0)
            break;
    }
    for (const auto& [group, attribute] : content.group_attributes) {
        Id place(H5Gopen2(file, group.c_str(), H5P_DEFAULT), H5Gclose);
        write_attribute(place, attribute.first, attribute.second, content.plain);
        place.close();
    }
    file.close();
    return hashes;
}

/// Whether a file holds the content, bit by bit.
/// @param hashes  Of the blocks that were made.
bool holds(const std::filesystem::path& path, const Hdf5Content& content,
           const std::vector<std::uint64_t>& hashes)
{
    const Id file = open_file(path);
    std::size_t made = 0;
    std::string bytes;
    const auto agrees = [&](const void* values, std::size_t size, const auto& read) {
        bytes.resize(size);
        checked(read(bytes.data()));
        return values == nullptr ? hash(bytes.data(), size) == hashes.at(made++)
                                 : std::memcmp(bytes.data(), values, size) == 0;
    };
    for (const auto& [name, value] : content.attributes) {
        const Id attribute(H5Aopen(file, name.c_str(), H5P_DEFAULT), H5Aclose);
        const Encoded encoded = encode(name, value, content.plain);
        if (!agrees(encoded.data(), encoded.size(),
                    [&](void* out) { return H5Aread(attribute, encoded.memory_type, out); }))
            return false;
    }
    bool is_equal = true;
    for (const Hdf5Dataset& dataset : content.datasets) {
        const Id stored(H5Dopen2(file, dataset.name.c_str(), H5P_DEFAULT), H5Dclose);
        const Encoded encoded = encode(dataset, content.plain);
        for_each_block(encoded, dataset.extents, false, [&](const Block& block) {
            is_equal = is_equal && agrees(block.values, block.size, [&](void* out) {
                           return H5Dread(stored, encoded.memory_type, block.memory_space,
                                          block.file_space, H5P_DEFAULT, out);
                       });
            return is_equal;
        });
    }
    return is_equal;
}

} // namespace

void write_hdf5(const std::filesystem::path& path, const Hdf5Content& content,
                const std::function<void()>& before_renaming)
{
    const Silence silence;
    const auto fail = [&](const std::string& cause) {
        throw FileError(join("cannot write ", path.string(), ": ", cause));
    };
    // HDF5 crashes on some allocations that fail; its own buffers take a few MiB.
    constexpr std::uint64_t room = std::uint64_t{24} << 20;
    if (is_memory_limited() && address_space_left() < room)
        throw std::bad_alloc();
    try {
        std::vector<std::uint64_t> hashes;
        write_file_atomically(
            path,
            [&](int descriptor) {
                NewFile file{descriptor};
                hashes = make_file(content, file);
                if (file.error != 0)
                    fail(std::strerror(file.error));
            },
            [&](const auto& temporary) {
                if (!holds(temporary, content, hashes))
                    fail("what was read back differs");
            },
            before_renaming);
    } catch (const Hdf5Failure& failure) {
        fail(join("HDF5: ", failure.what()));
    }
}

} // namespace shape::internal
