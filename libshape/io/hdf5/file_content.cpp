// SPDX-License-Identifier: MIT

#include "libshape/io/hdf5/file_content.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <type_traits>

#include "libshape/base/format.h"
#include "libshape/base/to_size.h"
#include "libshape/io/hdf5/handles.h"
#include "libshape/io/hdf5/stored_rows.h"

namespace shape::internal {
namespace {

/// What breaks a rule of ours.
struct Refusal
{
    std::string rule;
};

/// What HDF5 refuses is the file's fault.
template <class Read>
auto found(const Read& read) -> Found<decltype(read())>
{
    try {
        return {read(), {}};
    } catch (const Hdf5Failure& failure) {
        return {{},
                join("cannot be read, the file is damaged or not written by libshape (HDF5: ",
                     failure.what(), ")")};
    } catch (const Refusal& refusal) {
        return {{}, refusal.rule};
    }
}

bool is_fixed_string(hid_t type)
{
    return H5Tget_class(type) == H5T_STRING && checked(H5Tis_variable_str(type)) == 0;
}

std::string read_text(hid_t attribute, hid_t type)
{
    const std::size_t size = H5Tget_size(type);
    if (!is_fixed_string(type) || size > longest_string)
        throw Refusal{"must be a string of fixed length"};
    std::string text(size, '\0');
    checked(H5Aread(attribute, type, text.data()));
    return text;
}

std::int64_t read_integer(hid_t attribute, hid_t type)
{
    if (H5Tget_class(type) != H5T_INTEGER || H5Tget_size(type) > sizeof(std::int64_t))
        throw Refusal{"must be an integer"};
    std::int64_t value = 0;
    checked(H5Aread(attribute, H5T_NATIVE_INT64, &value));
    return value;
}

StoredAttribute read_attribute(hid_t file, const std::string& name)
{
    StoredAttribute read{name, {}, {}};
    const std::string refusal =
        found([&] {
            const Id attribute(H5Aopen(file, name.c_str(), H5P_DEFAULT), H5Aclose);
            const Id space(H5Aget_space(attribute), H5Sclose);
            if (checked(H5Sget_simple_extent_npoints(space)) != 1)
                throw Refusal{"must be a single value"};
            const Id type(H5Aget_type(attribute), H5Tclose);
            read.text = found([&] { return read_text(attribute, type); });
            read.integer = found([&] { return read_integer(attribute, type); });
            return true;
        }).refusal;
    if (!refusal.empty()) {
        read.text.refusal = refusal;
        read.integer.refusal = refusal;
    }
    return read;
}

/// What an iteration of HDF5 lists. One by one, by their numbers, names take the square of the time.
struct Names
{
    std::vector<std::string> names;
    std::vector<bool> are_plain; ///< Of links: no link to elsewhere.
    bool is_out_of_memory = false;
    bool is_too_long = false; ///< One of them.

    /// Does not throw: HDF5 is between it and who does the iteration.
    herr_t add(const char* name, bool is_plain) noexcept
    try {
        is_too_long = std::strlen(name) > longest_string;
        if (is_too_long)
            return -1;
        names.emplace_back(name);
        are_plain.push_back(is_plain);
        return 0;
    } catch (...) {
        is_out_of_memory = true;
        return -1;
    }

    void check(herr_t result) const
    {
        if (is_out_of_memory)
            throw std::bad_alloc();
        if (is_too_long)
            throw Refusal{"has a member with too long a name"};
        checked(result);
    }
};

/// Those of the root group.
std::vector<StoredAttribute> read_attributes(hid_t file)
{
    Names listed;
    const auto add = [](hid_t, const char* name, const H5A_info_t*, void* all) {
        return static_cast<Names*>(all)->add(name, true);
    };
    listed.check(H5Aiterate2(file, H5_INDEX_NAME, H5_ITER_INC, nullptr, add, &listed));
    std::vector<StoredAttribute> attributes;
    for (const std::string& name : listed.names)
        attributes.push_back(read_attribute(file, name));
    return attributes;
}

/// What is in a group, in the order in which it was made if the file knows, else sorted.
Names list_members(hid_t file, const std::string& group)
{
    const Id opened(H5Gopen2(file, group.c_str(), H5P_DEFAULT), H5Gclose);
    const Id creation(H5Gget_create_plist(opened), H5Pclose);
    unsigned order = 0;
    checked(H5Pget_link_creation_order(creation, &order));
    const H5_index_t index =
        (order & H5P_CRT_ORDER_INDEXED) != 0 ? H5_INDEX_CRT_ORDER : H5_INDEX_NAME;
    Names listed;
    const auto add = [](hid_t, const char* name, const H5L_info_t* link, void* all) {
        return static_cast<Names*>(all)->add(name, link->type == H5L_TYPE_HARD);
    };
    listed.check(H5Literate(opened, index, H5_ITER_INC, nullptr, add, &listed));
    return listed;
}

StoredDataset::Type type_of(hid_t type)
{
    if (checked(H5Tequal(type, H5T_IEEE_F64LE)) > 0)
        return StoredDataset::Type::Float64;
    if (checked(H5Tequal(type, H5T_STD_I32LE)) > 0)
        return StoredDataset::Type::Int32;
    return is_fixed_string(type) ? StoredDataset::Type::FixedString : StoredDataset::Type::Other;
}

void declare_extents(hid_t space, StoredDataset& declared)
{
    const H5S_class_t kind = H5Sget_simple_extent_type(space);
    declared.rank =
        kind == H5S_SCALAR || kind == H5S_SIMPLE ? checked(H5Sget_simple_extent_ndims(space)) : -1;
    if (declared.rank < 0 || declared.rank > 3)
        return;
    std::vector<hsize_t> lengths(to_size(declared.rank));
    checked(H5Sget_simple_extent_dims(space, lengths.data(), nullptr));
    for (const hsize_t length : lengths)
        declared.extents.push_back(static_cast<Eigen::Index>(
            std::min<hsize_t>(length, std::numeric_limits<Eigen::Index>::max())));
}

void declare_storage(hid_t creation, StoredDataset& declared)
{
    using Layout = StoredDataset::Layout;
    const H5D_layout_t layout = H5Pget_layout(creation);
    declared.layout = layout == H5D_COMPACT      ? Layout::Compact
                      : layout == H5D_CONTIGUOUS ? Layout::Contiguous
                      : layout == H5D_CHUNKED    ? Layout::Chunked
                                                 : Layout::Other;
    if (declared.layout == Layout::Other)
        return;
    declared.is_external = checked(H5Pget_external_count(creation)) > 0;
    for (int i = 0; i < checked(H5Pget_nfilters(creation)); ++i) {
        unsigned flags = 0;
        std::size_t parameters = 0;
        unsigned configuration = 0;
        declared.filters.push_back(
            checked(H5Pget_filter2(creation, static_cast<unsigned>(i), &flags, &parameters, nullptr,
                                   0, nullptr, &configuration)));
    }
    if (declared.layout != Layout::Chunked)
        return;
    std::array<hsize_t, H5S_MAX_RANK> chunk{};
    const int rank = checked(H5Pget_chunk(creation, H5S_MAX_RANK, chunk.data()));
    for (int d = 0; d < rank; ++d)
        declared.chunk.push_back(static_cast<Eigen::Index>(
            std::clamp<hsize_t>(chunk[to_size(d)], 1, std::numeric_limits<int>::max())));
}

/// Where the chunks stand, in row-major order of their places.
std::vector<ChunkTable::Chunk> list_chunks(hid_t dataset, const StoredDataset& declared,
                                           std::uint64_t file_size)
{
    std::array<hsize_t, 3> extents{1, 1, 1};
    std::array<hsize_t, 3> step{1, 1, 1};
    std::copy(declared.extents.begin(), declared.extents.end(), extents.begin());
    std::copy(declared.chunk.begin(), declared.chunk.end(), step.begin());
    std::vector<ChunkTable::Chunk> chunks;
    for (hsize_t i = 0; i < extents[0]; i += step[0])
        for (hsize_t j = 0; j < extents[1]; j += step[1])
            for (hsize_t k = 0; k < extents[2]; k += step[2]) {
                const std::array<hsize_t, 3> place{i, j, k};
                haddr_t offset = HADDR_UNDEF;
                hsize_t size = 0;
                unsigned skipped = 0;
                checked(
                    H5Dget_chunk_info_by_coord(dataset, place.data(), &skipped, &offset, &size));
                if (offset == HADDR_UNDEF || !lies_in_file({offset, size, skipped}, file_size))
                    throw Refusal{
                        join("has no values, or such beyond the end of the file, at row ", i)};
                chunks.push_back({offset, size, skipped});
            }
    return chunks;
}

/// A file open for reading, and what has been read of it.
class ContentReader
{
public:
    ContentReader(hid_t file, std::uint64_t file_size) : file_(file), file_size_(file_size)
    {
        content_.attributes = found([&] { return read_attributes(file_); });
        read_group("/");
        for (const std::string& member : std::vector(content_.groups["/"].value))
            if (content_.objects["/" + member].refusal.empty())
                read_group("/" + member);
    }

    [[nodiscard]] FileContent take() { return std::move(content_); }

private:
    void read_group(const std::string& group)
    {
        const Found<Names> members = found([&] { return list_members(file_, group); });
        content_.groups[group] = {members.value.names, members.refusal};
        for (std::size_t i = 0; i < members.value.names.size(); ++i) {
            const std::string name = (group == "/" ? "" : group) + "/" + members.value.names[i];
            StoredObject& object = content_.objects[name];
            if (members.value.are_plain[i])
                object.dataset = found([&] { return read_dataset(name); });
            else
                object.refusal = "is a link to elsewhere; only plain members are read";
        }
    }

    [[nodiscard]] StoredDataset read_dataset(const std::string& name)
    {
        const Id dataset(H5Dopen2(file_, name.c_str(), H5P_DEFAULT), H5Dclose);
        const Id type(H5Dget_type(dataset), H5Tclose);
        const Id space(H5Dget_space(dataset), H5Sclose);
        const Id creation(H5Dget_create_plist(dataset), H5Pclose);
        StoredDataset declared{.type = type_of(type), .value_size = H5Tget_size(type)};
        declare_extents(space, declared);
        declare_storage(creation, declared);
        if (declared.type == StoredDataset::Type::Other ||
            !broken_rule(declared, file_size_).empty())
            return declared;
        const std::size_t before = content_.values.size();
        declared.refusal =
            found([&] { return read_values(dataset, type, declared), true; }).refusal;
        if (!declared.refusal.empty()) {
            content_.values.resize(before);
            declared.values = {};
        }
        return declared;
    }

    void read_values(hid_t dataset, hid_t type, StoredDataset& declared)
    {
        using Type = StoredDataset::Type;
        using Layout = StoredDataset::Layout;
        if (declared.type == Type::Float64 && declared.layout == Layout::Contiguous) {
            declared.offset = H5Dget_offset(dataset);
        } else if (declared.type == Type::Float64 && declared.layout == Layout::Chunked) {
            static_assert(std::has_unique_object_representations_v<ChunkTable::Chunk>);
            const auto chunks = list_chunks(dataset, declared, file_size_);
            const std::uint64_t size = chunks.size() * sizeof(chunks.front());
            std::memcpy(append(size, declared), chunks.data(), size);
        } else {
            const hid_t memory_type = declared.type == Type::Float64 ? H5T_NATIVE_DOUBLE
                                      : declared.type == Type::Int32 ? H5T_NATIVE_INT
                                                                     : type;
            const std::uint64_t size = to_size(declared.count()) * declared.value_size;
            if (size <= largest_array) // else whoever asks for them is told so
                checked(H5Dread(dataset, memory_type, H5S_ALL, H5S_ALL, H5P_DEFAULT,
                                append(size, declared)));
        }
    }

    /// Room for `size` more bytes of values.
    [[nodiscard]] char* append(std::uint64_t size, StoredDataset& declared)
    {
        std::string& values = content_.values;
        if (size > most_values * file_size_ - values.size())
            throw Refusal{"has values that other datasets have too: the file cannot hold them all"};
        declared.values = {values.size(), size};
        values.resize(values.size() + size);
        return values.data() + declared.values.begin;
    }

    static constexpr std::uint64_t most_values =
        4; // bytes out of one: places of small chunks take three

    hid_t file_;
    std::uint64_t file_size_;
    FileContent content_;
};

} // namespace

FileContent read_content(const std::filesystem::path& path, std::uint64_t file_size)
{
    const Silence silence;
    try {
        const Id file = open_file(path);
        return ContentReader(file, file_size).take();
    } catch (const Hdf5Failure& failure) {
        FileContent nothing;
        nothing.refusal = join("the HDF5 file is truncated or damaged (", failure.what(), ")");
        return nothing;
    }
}

} // namespace shape::internal
