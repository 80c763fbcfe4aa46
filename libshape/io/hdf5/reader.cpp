// SPDX-License-Identifier: MIT

#include "libshape/io/hdf5/reader.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <map>
#include <numeric>
#include <optional>
#include <unordered_set>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/to_size.h"
#include "libshape/io/file/input_file.h"
#include "libshape/io/file/line_reader.h"
#include "libshape/io/hdf5/handles.h"
#include "libshape/io/hdf5/rehearsal.h"

namespace shape::internal {
namespace {

constexpr std::uint64_t largest_hdf5_file = std::uint64_t{1} << 50;
constexpr Eigen::Index largest_array = Eigen::Index{8} << 30; // [byte], of one dataset in memory
constexpr Eigen::Index most_chunks = Eigen::Index{1} << 24;   // of one dataset
constexpr Eigen::Index best_packing = 1032;                   // of deflate: bytes out of one
constexpr hsize_t largest_chunk = hsize_t{64} << 20;          // [byte]

using IntMatrix = Eigen::Matrix<int, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// "(3, 0, 1)": the position of a value in row-major order.
std::string print_position(const Extents& extents, Eigen::Index index)
{
    std::string text = ")";
    for (auto length = extents.rbegin(); length != extents.rend(); ++length) {
        text.insert(0, join(length == std::prev(extents.rend()) ? "" : ", ", index % *length));
        index /= *length;
    }
    return "(" + text;
}

std::string print_extents(const Extents& extents)
{
    std::string text;
    for (const Eigen::Index length : extents)
        text += (text.empty() ? "" : " by ") + (length == any_length ? "any" : join(length));
    return text.empty() ? "single value" : text;
}

/// Names of what is in a group, or of attributes.
struct Listing
{
    std::vector<std::string> names; ///< In their order.
    std::unordered_set<std::string> set;

    void add(const std::string& name)
    {
        names.push_back(name);
        set.insert(name);
    }
};

/// What is not listed is not looked for: HDF5 goes other ways to a name that it does not find, through indices that no
/// rehearsal (rehearsal.h) has been to. So nothing is read of what cannot be listed.
struct OpenFile
{
    std::string path;
    Eigen::Index size; ///< [byte]
    Id id;
    mutable std::map<std::string, Listing> groups = {}; ///< Those listed so far.
    mutable std::optional<Listing> attributes = {};     ///< Likewise, of the file.
};

/// A dataset whose declaration has passed all checks; nothing is read yet.
struct StoredDataset
{
    Id dataset;
    Id type;
    Extents extents;
    Eigen::Index count;       ///< Product of the extents.
    Extents chunk;            ///< Extents of a chunk; empty if the values are not in chunks.
    std::vector<int> filters; ///< In the order of writing.

    [[nodiscard]] bool is_compressed() const
    {
        return std::ranges::find(filters, H5Z_FILTER_DEFLATE) != filters.end();
    }
};

/// A part of a file to be read; errors name it.
class Item
{
public:
    Item(const OpenFile& file, std::string name) : file_(file), name_(std::move(name)) {}

    [[noreturn]] void fail(const std::string& rule) const
    {
        throw InvalidInput(join(file_.path, ": ", name_, ": ", rule));
    }

    /// Runs `read`; what HDF5 refuses is the file's fault.
    template <class Read>
    [[nodiscard]] auto guarded(const Read& read) const
    {
        const Silence silence;
        try {
            return read();
        } catch (const Hdf5Failure& failure) {
            fail(join("cannot be read, the file is damaged or not written by libshape (HDF5: ",
                      failure.what(), ")"));
        }
    }

    /// What is in this group.
    [[nodiscard]] const Listing& members() const
    {
        if (const auto known = file_.groups.find(name_); known != file_.groups.end())
            return known->second;
        const Id opened(H5Gopen2(file_.id, name_.c_str(), H5P_DEFAULT), H5Gclose);
        const Id creation(H5Gget_create_plist(opened), H5Pclose);
        unsigned order = 0;
        checked(H5Pget_link_creation_order(creation, &order));
        const H5_index_t index = order & H5P_CRT_ORDER_INDEXED ? H5_INDEX_CRT_ORDER : H5_INDEX_NAME;
        H5G_info_t info;
        checked(H5Gget_info(opened, &info));
        Listing listing;
        for (hsize_t i = 0; i < info.nlinks; ++i) {
            std::array<char, longest_string + 1> name{};
            const ssize_t size = checked(H5Lget_name_by_idx(opened, ".", index, H5_ITER_INC, i,
                                                            name.data(), name.size(), H5P_DEFAULT));
            if (size > static_cast<ssize_t>(longest_string))
                fail("has a member with too long a name");
            listing.add(name.data());
        }
        return file_.groups.emplace(name_, std::move(listing)).first->second;
    }

    /// Whether all groups on the way and the object itself exist, as plain members of this file.
    [[nodiscard]] bool exists() const
    {
        std::string group = "/";
        std::size_t begin = 1;
        for (std::size_t end = name_.find('/', 1); true; end = name_.find('/', end + 1)) {
            const std::string prefix = name_.substr(0, end);
            if (!Item(file_, group).members().set.contains(prefix.substr(begin)))
                return false;
            group = prefix;
            begin = end + 1;
            H5L_info_t info;
            checked(H5Lget_info(file_.id, prefix.c_str(), &info, H5P_DEFAULT));
            if (info.type != H5L_TYPE_HARD)
                fail("is a link to elsewhere; only plain members are read");
            if (end == std::string::npos)
                return true;
        }
    }

    [[nodiscard]] StoredDataset open() const
    {
        if (!exists())
            fail("is missing");
        Id dataset(H5Dopen2(file_.id, name_.c_str(), H5P_DEFAULT), H5Dclose);
        Id type(H5Dget_type(dataset), H5Tclose);
        const Id space(H5Dget_space(dataset), H5Sclose);
        const Id creation(H5Dget_create_plist(dataset), H5Pclose);
        StoredDataset stored{std::move(dataset), std::move(type), read_extents(space), 1, {}, {}};
        const std::size_t value_size = H5Tget_size(stored.type);
        if (value_size == 0 || value_size > longest_string)
            fail(join("has values of ", value_size, " bytes; the limit is ", longest_string));
        check_storage(creation, stored);
        const Eigen::Index room = file_.size * (stored.is_compressed() ? best_packing : 1);
        for (const Eigen::Index length : stored.extents) {
            if (length < 1)
                fail("has no values");
            if (length > room / static_cast<Eigen::Index>(value_size) / stored.count)
                fail(join("declares ", print_extents(stored.extents), " values of ", value_size,
                          " bytes, more than the file can hold"));
            stored.count *= length;
        }
        hsize_t room_in_chunk = largest_chunk / value_size;
        for (const Eigen::Index length : stored.chunk)
            room_in_chunk /= static_cast<hsize_t>(length);
        if (room_in_chunk == 0)
            fail(join("has chunks of more than ", largest_chunk, " bytes"));
        return stored;
    }

    void check_extents(const Extents& extents, const Extents& expected) const
    {
        const bool agree =
            std::equal(extents.begin(), extents.end(), expected.begin(), expected.end(),
                       [](Eigen::Index a, Eigen::Index b) { return b == any_length || a == b; });
        if (!agree)
            fail(join("is ", print_extents(extents), ", must be ", print_extents(expected)));
    }

    /// A dataset of a numeric type that must be stored as exactly that.
    [[nodiscard]] StoredDataset open(const Extents& expected, hid_t type, const char* what) const
    {
        StoredDataset stored = open();
        check_extents(stored.extents, expected);
        if (checked(H5Tequal(stored.type, type)) == 0)
            fail(join("has values of another type, must be ", what));
        return stored;
    }

    /// Where the chunks of a dataset of doubles stand.
    [[nodiscard]] ChunkTable chunk_table(const StoredDataset& stored) const
    {
        ChunkTable table{.file = file_.path, .dataset = name_, .filters = stored.filters};
        std::copy(stored.extents.begin(), stored.extents.end(), table.extents.begin());
        std::copy(stored.chunk.begin(), stored.chunk.end(), table.chunk_extents.begin());
        const auto& [rows, across, deep] = table.extents;
        if (stored.chunk.empty()) { // row by row, as they stand one after the other
            table.chunk_extents = {1, across, deep};
            const haddr_t begin = H5Dget_offset(stored.dataset);
            const hsize_t size = sizeof(double) * static_cast<hsize_t>(across * deep);
            const auto end = static_cast<hsize_t>(file_.size);
            if (begin == HADDR_UNDEF || begin > end ||
                static_cast<hsize_t>(rows) * size > end - begin)
                fail("has no values, or such beyond the end of the file, or in its header");
            for (Eigen::Index i = 0; i < rows; ++i)
                table.chunks.push_back({begin + static_cast<hsize_t>(i) * size, size, 0});
            return table;
        }
        Eigen::Index count = 1;
        for (std::size_t d = 0; d < table.extents.size(); ++d)
            count *= (table.extents[d] - 1) / table.chunk_extents[d] + 1;
        if (count > most_chunks)
            fail(join("is stored in ", count, " chunks; the limit is ", most_chunks));
        for (Eigen::Index i = 0; i < rows; i += table.chunk_extents[0])
            for (Eigen::Index j = 0; j < across; j += table.chunk_extents[1])
                for (Eigen::Index k = 0; k < deep; k += table.chunk_extents[2]) {
                    const std::array<hsize_t, 3> place{
                        static_cast<hsize_t>(i), static_cast<hsize_t>(j), static_cast<hsize_t>(k)};
                    haddr_t offset = HADDR_UNDEF;
                    hsize_t size = 0;
                    unsigned skipped = 0;
                    checked(H5Dget_chunk_info_by_coord(stored.dataset, place.data(), &skipped,
                                                       &offset, &size));
                    const auto end = static_cast<hsize_t>(file_.size);
                    if (offset == HADDR_UNDEF || offset > end || size > end - offset)
                        fail(join("has no values, or such beyond the end of the file, at row ", i));
                    table.chunks.push_back({offset, size, skipped});
                }
        return table;
    }

    /// Values of a numeric type, by HDF5.
    template <class Matrix>
    [[nodiscard]] Matrix read(const StoredDataset& stored, hid_t memory_type) const
    {
        const Eigen::Index rows = stored.extents.empty() ? 1 : stored.extents.front();
        check_size(stored);
        Matrix values(rows, stored.count / rows);
        checked(H5Dread(stored.dataset, memory_type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()));
        return values;
    }

    void check_size(const StoredDataset& stored) const
    {
        if (stored.count > largest_array / static_cast<Eigen::Index>(H5Tget_size(stored.type)))
            throw LimitExceeded(join(file_.path, ": ", name_, ": has ", stored.count,
                                     " values; at most ", largest_array,
                                     " bytes are read into memory"));
    }

private:
    [[nodiscard]] Extents read_extents(hid_t space) const
    {
        const H5S_class_t kind = H5Sget_simple_extent_type(space);
        const int rank = checked(H5Sget_simple_extent_ndims(space));
        if ((kind != H5S_SCALAR && kind != H5S_SIMPLE) || rank > 3)
            fail("must be a single value or an array of at most 3 dimensions");
        std::vector<hsize_t> lengths(to_size(rank));
        checked(H5Sget_simple_extent_dims(space, lengths.data(), nullptr));
        Extents extents;
        for (const hsize_t length : lengths)
            extents.push_back(static_cast<Eigen::Index>(std::min<hsize_t>(length, PTRDIFF_MAX)));
        return extents;
    }

    /// Refuses storage in other files and filters that leave values unchecked; notes how the values are
    /// stored.
    void check_storage(hid_t creation, StoredDataset& stored) const
    {
        const H5D_layout_t layout = H5Pget_layout(creation);
        if (layout != H5D_COMPACT && layout != H5D_CONTIGUOUS && layout != H5D_CHUNKED)
            fail("has a virtual or unknown layout");
        if (checked(H5Pget_external_count(creation)) > 0)
            fail("has its values in another file");
        for (int i = 0; i < checked(H5Pget_nfilters(creation)); ++i) {
            unsigned flags = 0;
            std::size_t parameters = 0;
            unsigned configuration = 0;
            stored.filters.push_back(
                checked(H5Pget_filter2(creation, static_cast<unsigned>(i), &flags, &parameters,
                                       nullptr, 0, nullptr, &configuration)));
        }
        check_filters(stored);
        if (layout != H5D_CHUNKED)
            return;
        std::array<hsize_t, H5S_MAX_RANK> chunk{};
        const int rank = checked(H5Pget_chunk(creation, H5S_MAX_RANK, chunk.data()));
        for (int d = 0; d < rank; ++d)
            stored.chunk.push_back(static_cast<Eigen::Index>(
                std::clamp<hsize_t>(chunk[to_size(d)], 1, largest_chunk + 1)));
    }

    /// Doubles may be compressed, if a checksum stands over what is stored; all else has that alone.
    void check_filters(const StoredDataset& stored) const
    {
        const bool may_be_packed = checked(H5Tequal(stored.type, H5T_IEEE_F64LE)) > 0;
        if (may_be_packed &&
            (stored.filters == std::vector<int>{H5Z_FILTER_DEFLATE} ||
             stored.filters == std::vector<int>{H5Z_FILTER_SHUFFLE, H5Z_FILTER_DEFLATE}))
            fail(
                "is compressed without a checksum; write it with fletcher32 (h5py: "
                "fletcher32=True), "
                "which is what tells damage");
        std::vector<int> rest = stored.filters;
        if (!rest.empty() && rest.back() == H5Z_FILTER_FLETCHER32) {
            rest.pop_back();
            if (may_be_packed)
                for (const int filter : {H5Z_FILTER_DEFLATE, H5Z_FILTER_SHUFFLE})
                    if (!rest.empty() && rest.back() == filter)
                        rest.pop_back();
        }
        if (!rest.empty())
            fail(join(
                "is stored with filter ", rest.back(),
                " (compression?); only the checksum fletcher32 is read and, of float64 values, "
                "shuffle and deflate below it"));
    }

    const OpenFile& file_;
    std::string name_;
};

/// Attributes of the root group.
const Listing& list_attributes(const OpenFile& file)
{
    if (file.attributes)
        return *file.attributes;
    H5O_info_t info;
    checked(H5Oget_info2(file.id, &info, H5O_INFO_NUM_ATTRS));
    Listing listing;
    for (hsize_t i = 0; i < info.num_attrs; ++i) {
        std::array<char, longest_string + 1> name{};
        checked(H5Aget_name_by_idx(file.id, ".", H5_INDEX_NAME, H5_ITER_INC, i, name.data(),
                                   name.size(), H5P_DEFAULT));
        listing.add(name.data());
    }
    return file.attributes.emplace(std::move(listing));
}

/// Opens one of them that is a single value.
Id open_attribute(const Item& item, const OpenFile& file, const std::string& name)
{
    if (!list_attributes(file).set.contains(name))
        item.fail("is missing");
    Id attribute(H5Aopen(file.id, name.c_str(), H5P_DEFAULT), H5Aclose);
    const Id space(H5Aget_space(attribute), H5Sclose);
    if (checked(H5Sget_simple_extent_npoints(space)) != 1)
        item.fail("must be a single value");
    return attribute;
}

/// The text up to its padding.
std::string unpadded(std::string text)
{
    text.resize(std::min(text.find('\0'), text.size()));
    return text;
}

bool is_fixed_string(hid_t type)
{
    return H5Tget_class(type) == H5T_STRING && checked(H5Tis_variable_str(type)) == 0;
}

/// All rows, some at a time: what is fetched stands beside what is made of it.
void read_all(const StoredRows& rows, RowMatrix& values)
{
    const Eigen::Index step =
        std::max<Eigen::Index>(1, (Eigen::Index{32} << 20) / (8 * rows.size()));
    for (Eigen::Index first = 0; first < rows.count(); first += step) {
        std::vector<Eigen::Index> wanted(to_size(std::min(step, rows.count() - first)));
        std::iota(wanted.begin(), wanted.end(), first);
        rows.unpack(*rows.fetch(std::move(wanted)), [&](std::size_t i) {
            return values.row(first + static_cast<Eigen::Index>(i)).data();
        });
    }
}

bool begins_as_hdf5(const std::filesystem::path& path, std::uint64_t offset)
{
    std::array<char, 8> signature{};
    std::ifstream file(path, std::ios::binary);
    file.seekg(static_cast<std::streamoff>(offset)).read(signature.data(), signature.size());
    return std::string_view(signature.data(), signature.size()) == "\x89HDF\r\n\x1a\n";
}

} // namespace

struct Hdf5File::State : OpenFile
{
};

Hdf5File::Hdf5File(const std::filesystem::path& path)
{
    const std::uint64_t size = checked_file_size(path, largest_hdf5_file);
    if (!begins_as_hdf5(path, 0)) {
        for (std::uint64_t user_block = 512; user_block < size; user_block *= 2)
            if (begins_as_hdf5(path, user_block))
                throw InvalidInput(join(path.string(), ": has a user block of ", user_block,
                                        " bytes, which is not read; take it away (`h5unjam`)"));
        throw InvalidInput(path.string() + ": is not an HDF5 file");
    }
    rehearse_if_wanted(path);
    const Silence silence;
    try {
        state_.reset(new State{{path.string(), static_cast<Eigen::Index>(size), open_file(path)}});
    } catch (const Hdf5Failure& failure) {
        throw InvalidInput(
            join(path.string(), ": the HDF5 file is truncated or damaged (", failure.what(), ")"));
    }
}

Hdf5File::~Hdf5File()
{
    const Silence silence;
    state_.reset();
}

const std::string& Hdf5File::path() const
{
    return state_->path;
}

bool Hdf5File::has(const std::string& name) const
{
    const Item item(*state_, name);
    return item.guarded([&] { return item.exists(); });
}

std::vector<std::string> Hdf5File::members(const std::string& group) const
{
    const Item item(*state_, group);
    return item.guarded([&] {
        return group == "/" || item.exists() ? item.members().names : std::vector<std::string>();
    });
}

Extents Hdf5File::extents(const std::string& name) const
{
    const Item item(*state_, name);
    return item.guarded([&] { return item.open().extents; });
}

bool Hdf5File::is_compressed(const std::string& name) const
{
    const Item item(*state_, name);
    return item.guarded([&] { return item.open().is_compressed(); });
}

StoredRows Hdf5File::rows(const std::string& name, const Extents& expected) const
{
    const Item item(*state_, name);
    return StoredRows(item.guarded(
        [&] { return item.chunk_table(item.open(expected, H5T_IEEE_F64LE, "float64")); }));
}

RowMatrix Hdf5File::numbers(const std::string& name, const Extents& expected) const
{
    const Item item(*state_, name);
    std::optional<StoredRows> stored_rows;
    RowMatrix values = item.guarded([&]() -> RowMatrix {
        const StoredDataset stored = item.open(expected, H5T_IEEE_F64LE, "float64");
        const Id creation(H5Dget_create_plist(stored.dataset), H5Pclose);
        if (H5Pget_layout(creation) == H5D_COMPACT) // in the header, which HDF5 has read already
            return item.read<RowMatrix>(stored, H5T_NATIVE_DOUBLE);
        item.check_size(stored);
        stored_rows.emplace(item.chunk_table(stored));
        return {stored_rows->count(), stored_rows->size()};
    });
    if (stored_rows) {
        read_all(*stored_rows, values);
        return values;
    }
    if (!values.allFinite()) {
        const double* bad = std::find_if(values.data(), values.data() + values.size(),
                                         [](double value) { return !std::isfinite(value); });
        item.fail(join("value ", print_position(extents(name), bad - values.data()), " is ", *bad,
                       ", must be finite"));
    }
    return values;
}

IntMatrix Hdf5File::integers(const std::string& name, const Extents& expected) const
{
    const Item item(*state_, name);
    return item.guarded([&] {
        return item.read<IntMatrix>(item.open(expected, H5T_STD_I32LE, "int32"), H5T_NATIVE_INT);
    });
}

std::vector<std::string> Hdf5File::strings(const std::string& name, Eigen::Index expected) const
{
    const Item item(*state_, name);
    return item.guarded([&] {
        const StoredDataset stored = item.open();
        item.check_extents(stored.extents, {expected});
        if (!is_fixed_string(stored.type))
            item.fail("must hold strings of fixed length");
        const std::size_t size = H5Tget_size(stored.type);
        std::string packed(size * to_size(stored.count), '\0');
        checked(H5Dread(stored.dataset, stored.type, H5S_ALL, H5S_ALL, H5P_DEFAULT, packed.data()));
        std::vector<std::string> strings;
        for (std::size_t begin = 0; begin < packed.size(); begin += size) {
            std::string text = unpadded(packed.substr(begin, size));
            if (!is_utf8(text))
                item.fail(join("string ", strings.size(), " is not UTF-8"));
            strings.push_back(std::move(text));
        }
        return strings;
    });
}

bool Hdf5File::has_attribute(const std::string& name) const
{
    const Item item(*state_, "attribute " + name);
    return item.guarded([&] { return list_attributes(*state_).set.contains(name); });
}

std::vector<std::string> Hdf5File::attributes() const
{
    const Item item(*state_, "attributes");
    return item.guarded([&] { return list_attributes(*state_).names; });
}

std::string Hdf5File::text_attribute(const std::string& name) const
{
    const Item item(*state_, "attribute " + name);
    return item.guarded([&] {
        const Id attribute = open_attribute(item, *state_, name);
        const Id type(H5Aget_type(attribute), H5Tclose);
        const std::size_t size = H5Tget_size(type);
        if (!is_fixed_string(type) || size > longest_string)
            item.fail("must be a string of fixed length");
        std::string text(size, '\0');
        checked(H5Aread(attribute, type, text.data()));
        return unpadded(std::move(text));
    });
}

std::int64_t Hdf5File::integer_attribute(const std::string& name) const
{
    const Item item(*state_, "attribute " + name);
    return item.guarded([&] {
        const Id attribute = open_attribute(item, *state_, name);
        const Id type(H5Aget_type(attribute), H5Tclose);
        if (H5Tget_class(type) != H5T_INTEGER || H5Tget_size(type) > sizeof(std::int64_t))
            item.fail("must be an integer");
        std::int64_t value = 0;
        checked(H5Aread(attribute, H5T_NATIVE_INT64, &value));
        return value;
    });
}

void Hdf5File::fail(const std::string& name, const std::string& rule) const
{
    throw InvalidInput(join(state_->path, ": ", name, ": ", rule));
}

namespace {

/// Runs what may be refused.
template <class Read>
bool succeeds(const Read& read)
{
    try {
        (void)read();
        return true;
    } catch (const InvalidInput&) {
        return false;
    } catch (const LimitExceeded&) {
        return false;
    }
}

void read_members(const Hdf5File& file, const std::string& group, int levels)
{
    for (const std::string& member : file.members(group.empty() ? "/" : group)) {
        const std::string name = group + "/" + member;
        if (levels > 1) // of a dataset too: who looks for a name in it asks for them
            succeeds([&] { return read_members(file, name, levels - 1), true; });
        Extents extents;
        if (!succeeds([&] { return extents = file.extents(name); }))
            continue;
        if (!succeeds([&] { return file.rows(name, extents); }) &&
            !succeeds([&] { return file.numbers(name, extents); }) &&
            !succeeds([&] { return file.integers(name, extents); }) && extents.size() == 1)
            succeeds([&] { return file.strings(name, extents.front()); });
    }
}

} // namespace

void read_everything(const Hdf5File& file)
{
    constexpr int levels = 4; // files of libshape have two
    const bool are_listed = succeeds([&] {
        for (const std::string& name : file.attributes())
            succeeds([&] { return file.text_attribute(name); }) ||
                succeeds([&] { return file.integer_attribute(name); });
        return true;
    });
    read_members(file, "",
                 levels); // by whoever does not ask for attributes, though they cannot be listed
    if (!are_listed)
        file.fail("attributes", "cannot be listed");
}

} // namespace shape::internal
