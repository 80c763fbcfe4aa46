// SPDX-License-Identifier: MIT

#include "libshape/io/hdf5_file.h"

#include <hdf5.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <functional>
#include <numeric>
#include <stdexcept>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/io/input_file.h"
#include "libshape/io/line_reader.h"
#include "libshape/io/output_file.h"

namespace shape {
namespace {

constexpr std::uint64_t largest_file = std::uint64_t{8} << 30;
constexpr hsize_t largest_chunk = hsize_t{64} << 20; // [byte]
constexpr std::size_t chunk_size = 1 << 20;          // [byte]
constexpr std::size_t longest_string = 4096;         // [byte]

using IntMatrix = Eigen::Matrix<int, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Keeps HDF5 from printing its errors in this thread while it lives.
class Silence
{
public:
    Silence()
    {
        H5Eget_auto2(H5E_DEFAULT, &function_, &data_);
        H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
    }
    ~Silence()
    {
        if (!stays_)
            H5Eset_auto2(H5E_DEFAULT, function_, data_);
    }
    Silence(const Silence&) = delete;
    Silence& operator=(const Silence&) = delete;

    /// For good: HDF5 1.10 loses memory when it opens a damaged file, and would print that at exit.
    void stay() { stays_ = true; }

private:
    bool stays_ = false;
    H5E_auto2_t function_ = nullptr;
    void* data_ = nullptr;
};

/// What HDF5 says about its last error, as the innermost function put it.
std::string last_error()
{
    std::string text;
    const auto take = [](unsigned n, const H5E_error2_t* error, void* out) -> herr_t {
        if (n == 0 && error->desc != nullptr)
            *static_cast<std::string*>(out) = error->desc;
        return 0;
    };
    H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, take, &text);
    return text.empty() ? "unknown cause" : text;
}

/// An HDF5 call failed; the callers say which file and what it means there.
class Hdf5Failure : public std::runtime_error
{
public:
    Hdf5Failure() : std::runtime_error(last_error()) {}
};

/// Passes on a result that is not negative: so every call is checked.
template <class Result>
Result checked(Result result)
{
    if (result < 0)
        throw Hdf5Failure();
    return result;
}

/// An identifier and the function that closes it.
class Id
{
public:
    Id(hid_t id, herr_t (*closer)(hid_t)) : id_(checked(id)), close_(closer) {}
    ~Id()
    {
        if (id_ >= 0)
            close_(id_);
    }
    Id(Id&& other) noexcept : id_(std::exchange(other.id_, -1)), close_(other.close_) {}
    Id& operator=(Id&&) = delete;

    operator hid_t() const { return id_; }

    /// Closing may write, and fail.
    void close() { checked(close_(std::exchange(id_, -1))); }

private:
    hid_t id_;
    herr_t (*close_)(hid_t);
};

std::vector<hsize_t> dimensions(const Extents& extents)
{
    return {extents.begin(), extents.end()};
}

Id make_space(const Extents& extents)
{
    if (extents.empty())
        return {H5Screate(H5S_SCALAR), H5Sclose};
    return {H5Screate_simple(static_cast<int>(extents.size()), dimensions(extents).data(), nullptr),
            H5Sclose};
}

/// Fixed-length UTF-8, padded with NUL: unlike the heap of variable-length strings it has checksums.
Id make_string_type(std::size_t size)
{
    Id type(H5Tcopy(H5T_C_S1), H5Tclose);
    checked(H5Tset_size(type, size));
    checked(H5Tset_strpad(type, H5T_STR_NULLPAD));
    checked(H5Tset_cset(type, H5T_CSET_UTF8));
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

Encoded encode(std::span<const double> values, const std::string&)
{
    return {{H5Tcopy(H5T_IEEE_F64LE), H5Tclose},
            {H5Tcopy(H5T_NATIVE_DOUBLE), H5Tclose},
            values.data(),
            sizeof(double),
            values.size(),
            {}};
}

Encoded encode(std::span<const int> values, const std::string&)
{
    return {{H5Tcopy(H5T_STD_I32LE), H5Tclose},
            {H5Tcopy(H5T_NATIVE_INT), H5Tclose},
            values.data(),
            sizeof(int),
            values.size(),
            {}};
}

Encoded encode(std::span<const std::int64_t> values, const std::string&)
{
    return {{H5Tcopy(H5T_STD_I64LE), H5Tclose},
            {H5Tcopy(H5T_NATIVE_INT64), H5Tclose},
            values.data(),
            sizeof(std::int64_t),
            values.size(),
            {}};
}

Encoded encode(std::span<const std::string> values, const std::string& name)
{
    std::size_t size = 1;
    for (const std::string& text : values) {
        if (text.find('\0') != std::string::npos || !is_utf8(text) || text.size() > longest_string)
            throw InvalidInput(join(name, ": ", in_quotes(text),
                                    " must be UTF-8 without NUL, at most ", longest_string,
                                    " bytes"));
        size = std::max(size, text.size());
    }
    std::string packed;
    packed.reserve(size * values.size());
    for (const std::string& text : values) {
        packed += text;
        packed.append(size - text.size(), '\0');
    }
    return {make_string_type(size), make_string_type(size), nullptr, size,
            values.size(),          std::move(packed)};
}

Encoded encode(const Hdf5Rows& rows, const std::string& name)
{
    Encoded encoded = encode(std::span<const double>(), name);
    encoded.rows = rows;
    return encoded;
}

std::size_t product(std::span<const Eigen::Index> extents)
{
    return static_cast<std::size_t>(
        std::accumulate(extents.begin(), extents.end(), Eigen::Index{1}, std::multiplies()));
}

Encoded encode(const Hdf5Dataset& dataset)
{
    Encoded encoded = std::visit([&](const auto& values) { return encode(values, dataset.name); },
                                 dataset.values);
    if (encoded.rows)
        encoded.count = product(dataset.extents);
    return encoded;
}

Encoded encode(const std::string& name, const Hdf5Value& value)
{
    return std::visit([&](const auto& v) { return encode(std::span(&v, 1), name); }, value);
}

/// Objects without time stamps, so that equal contents give equal bytes.
Id make_creation_list(hid_t kind)
{
    Id list(H5Pcreate(kind), H5Pclose);
    checked(H5Pset_obj_track_times(list, false));
    return list;
}

/// Chunks of about 1 MiB of consecutive values.
std::vector<hsize_t> chunk_dimensions(const Extents& extents, std::size_t value_size)
{
    std::vector<hsize_t> chunk = dimensions(extents);
    hsize_t budget = std::max<hsize_t>(chunk_size / value_size, 1);
    for (auto length = chunk.rbegin(); length != chunk.rend(); ++length) {
        *length = std::min(*length, budget);
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

/// Runs action(block) for a dataset's values, whole rows of about 1 MiB together at a time.
void for_each_block(const Encoded& values, const Extents& extents,
                    const std::function<void(const Block&)>& action)
{
    if (extents.empty())
        return action({H5S_ALL, H5S_ALL, values.data(), values.size()});
    const std::size_t row_size = product(std::span(extents).subspan(1));
    const std::vector<hsize_t> whole = dimensions(extents);
    const hsize_t step = chunk_dimensions(extents, values.value_size).front();
    const Id file_space = make_space(extents);
    std::vector<double> made;
    std::vector<hsize_t> start(whole.size(), 0);
    for (; start[0] < whole[0]; start[0] += step) {
        std::vector<hsize_t> count = whole;
        count[0] = std::min(step, whole[0] - start[0]);
        checked(H5Sselect_hyperslab(file_space, H5S_SELECT_SET, start.data(), nullptr, count.data(),
                                    nullptr));
        const Id memory_space(
            H5Screate_simple(static_cast<int>(count.size()), count.data(), nullptr), H5Sclose);
        const void* block = nullptr;
        if (values.rows) {
            made.resize(count[0] * row_size);
            for (std::size_t i = 0; i < count[0]; ++i)
                values.rows(static_cast<Eigen::Index>(start[0] + i),
                            std::span(made).subspan(i * row_size, row_size));
            block = made.data();
        } else {
            block =
                static_cast<const char*>(values.data()) + start[0] * row_size * values.value_size;
        }
        action({file_space, memory_space, block, count[0] * row_size * values.value_size});
    }
}

/// Creates the group of a dataset. Groups remember the order of their members: that of labels.
void create_group(hid_t file, const std::string& dataset)
{
    const std::string group = dataset.substr(0, dataset.rfind('/'));
    if (group.empty() || checked(H5Lexists(file, group.c_str(), H5P_DEFAULT)) > 0)
        return;
    const Id list = make_creation_list(H5P_GROUP_CREATE);
    checked(H5Pset_link_creation_order(list, H5P_CRT_ORDER_TRACKED | H5P_CRT_ORDER_INDEXED));
    Id(H5Gcreate2(file, group.c_str(), H5P_DEFAULT, list, H5P_DEFAULT), H5Gclose).close();
}

void write_dataset(hid_t file, const Hdf5Dataset& dataset)
{
    const Encoded values = encode(dataset);
    const Id space = make_space(dataset.extents);
    const auto count = static_cast<std::size_t>(checked(H5Sget_simple_extent_npoints(space)));
    if (count != values.count || count == 0)
        throw InvalidInput(join(dataset.name, ": has ", values.count, " values, must have ", count,
                                " and at least 1"));
    create_group(file, dataset.name);
    const Id creation = make_creation_list(H5P_DATASET_CREATE);
    if (dataset.extents.empty()) {
        checked(H5Pset_layout(creation, H5D_COMPACT)); // within the checksummed header
    } else {
        const std::vector<hsize_t> chunk = chunk_dimensions(dataset.extents, values.value_size);
        checked(H5Pset_chunk(creation, static_cast<int>(chunk.size()), chunk.data()));
        checked(H5Pset_fletcher32(creation));
    }
    const Id link(H5Pcreate(H5P_LINK_CREATE), H5Pclose);
    checked(H5Pset_char_encoding(link, H5T_CSET_UTF8));
    Id stored(
        H5Dcreate2(file, dataset.name.c_str(), values.type, space, link, creation, H5P_DEFAULT),
        H5Dclose);
    for_each_block(values, dataset.extents, [&](const Block& block) {
        checked(H5Dwrite(stored, values.memory_type, block.memory_space, block.file_space,
                         H5P_DEFAULT, block.values));
    });
    stored.close();
}

void write_attribute(hid_t file, const std::string& name, const Hdf5Value& value)
{
    const Encoded encoded = encode(name, value);
    Id attribute(
        H5Acreate2(file, name.c_str(), encoded.type, make_space({}), H5P_DEFAULT, H5P_DEFAULT),
        H5Aclose);
    checked(H5Awrite(attribute, encoded.memory_type, encoded.data()));
    attribute.close();
}

/// The bytes of an HDF5 file made in memory.
class Image
{
public:
    Image() = default;
    ~Image() { std::free(bytes_); }
    Image(const Image&) = delete;
    Image& operator=(const Image&) = delete;

    /// Up to the end that the superblock names: the buffer is longer.
    [[nodiscard]] std::string_view bytes() const
    {
        constexpr std::size_t end_of_file = 28; // offset in superblocks of version 2 and 3
        std::uint64_t size = 0;
        std::memcpy(&size, static_cast<char*>(bytes_) + end_of_file, sizeof(size));
        return {static_cast<char*>(bytes_), size};
    }

    /// Makes a file with this access list live in memory, and leave its bytes here when it closes.
    /// (H5Fget_file_image() gives bytes before that, with a wrong checksum of the superblock.)
    void receive(hid_t access)
    {
        using Operation = H5FD_file_image_op_t;
        H5FD_file_image_callbacks_t calls{};
        calls.image_malloc = [](std::size_t size, Operation, void*) { return std::malloc(size); };
        calls.image_memcpy = [](void* to, const void* from, std::size_t size, Operation, void*) {
            return std::memcpy(to, from, size);
        };
        calls.image_realloc = [](void* bytes, std::size_t size, Operation, void*) {
            return std::realloc(bytes, size);
        };
        calls.image_free = [](void* bytes, Operation operation, void* image) -> herr_t {
            if (operation == H5FD_FILE_IMAGE_OP_FILE_CLOSE)
                static_cast<Image*>(image)->bytes_ = bytes;
            else
                std::free(bytes);
            return 0;
        };
        calls.udata_copy = [](void* image) { return image; };
        calls.udata_free = [](void*) -> herr_t { return 0; };
        calls.udata = this;
        checked(H5Pset_fapl_core(access, std::size_t{4} << 20, false));
        checked(H5Pset_file_image_callbacks(access, &calls));
    }

private:
    void* bytes_ = nullptr;
};

/// Makes the file in memory: thus no error of the disk meets HDF5, which does not report them all.
void make_image(const Hdf5Content& content, Image& image)
{
    static std::atomic<unsigned> counter{0};
    const std::string unique = join("/dev/null/shape-", counter++); // no such file can exist
    const Id access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
    image.receive(access);
    checked(H5Pset_libver_bounds(access, H5F_LIBVER_LATEST, H5F_LIBVER_LATEST));
    Id file(H5Fcreate(unique.c_str(), H5F_ACC_TRUNC, make_creation_list(H5P_FILE_CREATE), access),
            H5Fclose);
    for (const auto& [name, value] : content.attributes)
        write_attribute(file, name, value);
    for (const Hdf5Dataset& dataset : content.datasets)
        write_dataset(file, dataset);
    file.close();
}

Id open_file(const std::filesystem::path& path)
{
    const Id access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
    // Files are replaced as a whole, never changed: readers need no lock.
    checked(H5Pset_file_locking(access, false, true));
    return {H5Fopen(path.c_str(), H5F_ACC_RDONLY, access), H5Fclose};
}

/// Whether a file holds the content, bit by bit.
bool holds(const std::filesystem::path& path, const Hdf5Content& content)
{
    const Id file = open_file(path);
    bool is_equal = true;
    std::string bytes;
    const auto compare = [&](const void* values, std::size_t size, const auto& read) {
        bytes.assign(size, '\0');
        checked(read(bytes.data()));
        is_equal = is_equal && std::memcmp(bytes.data(), values, size) == 0;
    };
    for (const auto& [name, value] : content.attributes) {
        const Id attribute(H5Aopen(file, name.c_str(), H5P_DEFAULT), H5Aclose);
        const Encoded encoded = encode(name, value);
        compare(encoded.data(), encoded.size(),
                [&](void* out) { return H5Aread(attribute, encoded.memory_type, out); });
    }
    for (const Hdf5Dataset& dataset : content.datasets) {
        const Id stored(H5Dopen2(file, dataset.name.c_str(), H5P_DEFAULT), H5Dclose);
        const Encoded encoded = encode(dataset);
        for_each_block(encoded, dataset.extents, [&](const Block& block) {
            compare(block.values, block.size, [&](void* out) {
                return H5Dread(stored, encoded.memory_type, block.memory_space, block.file_space,
                               H5P_DEFAULT, out);
            });
        });
    }
    return is_equal;
}

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

} // namespace

void write_hdf5(const std::filesystem::path& path, const Hdf5Content& content)
{
    const Silence silence;
    const auto fail = [&](const std::string& cause) {
        throw FileError(join("cannot write ", path.string(), ": ", cause));
    };
    try {
        Image image;
        make_image(content, image);
        write_file_atomically(path, image.bytes(), [&](const auto& temporary) {
            if (!holds(temporary, content))
                fail("what was read back differs");
        });
    } catch (const Hdf5Failure& failure) {
        fail(join("HDF5: ", failure.what()));
    }
}

namespace {

struct OpenFile
{
    std::string path;
    Eigen::Index size; ///< [byte]
    Id id;
};

/// A dataset whose declaration has passed all checks; nothing is read yet.
struct StoredDataset
{
    Id dataset;
    Id type;
    Extents extents;
    Eigen::Index count; ///< Product of the extents.
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
    auto guarded(const Read& read) const
    {
        Silence silence;
        try {
            return read();
        } catch (const Hdf5Failure& failure) {
            silence.stay();
            fail(join("cannot be read, the file is damaged or none of ours (HDF5: ", failure.what(),
                      ")"));
        }
    }

    /// Whether all groups on the way and the object itself exist, as plain members of this file.
    [[nodiscard]] bool exists() const
    {
        for (std::size_t end = name_.find('/', 1); true; end = name_.find('/', end + 1)) {
            const std::string part = name_.substr(0, end);
            if (checked(H5Lexists(file_.id, part.c_str(), H5P_DEFAULT)) == 0)
                return false;
            H5L_info_t info;
            checked(H5Lget_info(file_.id, part.c_str(), &info, H5P_DEFAULT));
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
        StoredDataset stored{std::move(dataset), std::move(type), read_extents(space), 1};
        const std::size_t value_size = H5Tget_size(stored.type);
        if (value_size == 0 || value_size > longest_string)
            fail(join("has values of ", value_size, " bytes; the limit is ", longest_string));
        for (const Eigen::Index length : stored.extents) {
            if (length < 1)
                fail("has no values");
            if (length > file_.size / static_cast<Eigen::Index>(value_size) / stored.count)
                fail(join("declares ", print_extents(stored.extents), " values of ", value_size,
                          " bytes, more than the file can hold"));
            stored.count *= length;
        }
        check_storage(creation, value_size);
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

    /// Values of a numeric type that must be stored as exactly that.
    template <class Matrix>
    Matrix read(const Extents& expected, hid_t type, hid_t memory_type, const char* what) const
    {
        const StoredDataset stored = open();
        check_extents(stored.extents, expected);
        if (checked(H5Tequal(stored.type, type)) == 0)
            fail(join("has values of another type, must be ", what));
        const Eigen::Index rows = stored.extents.empty() ? 1 : stored.extents.front();
        Matrix values(rows, stored.count / rows);
        checked(H5Dread(stored.dataset, memory_type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()));
        return values;
    }

private:
    [[nodiscard]] Extents read_extents(hid_t space) const
    {
        const H5S_class_t kind = H5Sget_simple_extent_type(space);
        const int rank = checked(H5Sget_simple_extent_ndims(space));
        if ((kind != H5S_SCALAR && kind != H5S_SIMPLE) || rank > 3)
            fail("must be a single value or an array of at most 3 dimensions");
        std::vector<hsize_t> lengths(static_cast<std::size_t>(rank));
        checked(H5Sget_simple_extent_dims(space, lengths.data(), nullptr));
        Extents extents;
        for (const hsize_t length : lengths)
            extents.push_back(static_cast<Eigen::Index>(std::min<hsize_t>(length, PTRDIFF_MAX)));
        return extents;
    }

    /// Refuses storage in other files, other filters than the checksum, and huge chunks.
    void check_storage(hid_t creation, std::size_t value_size) const
    {
        const H5D_layout_t layout = H5Pget_layout(creation);
        if (layout != H5D_COMPACT && layout != H5D_CONTIGUOUS && layout != H5D_CHUNKED)
            fail("has a virtual or unknown layout");
        if (checked(H5Pget_external_count(creation)) > 0)
            fail("has its values in another file");
        for (int i = checked(H5Pget_nfilters(creation)) - 1; i >= 0; --i) {
            unsigned flags = 0;
            std::size_t parameters = 0;
            unsigned configuration = 0;
            const H5Z_filter_t filter =
                checked(H5Pget_filter2(creation, static_cast<unsigned>(i), &flags, &parameters,
                                       nullptr, 0, nullptr, &configuration));
            if (filter != H5Z_FILTER_FLETCHER32)
                fail(join("is stored with filter ", filter,
                          " (compression?); only the checksum fletcher32 is read"));
        }
        if (layout != H5D_CHUNKED)
            return;
        std::array<hsize_t, H5S_MAX_RANK> chunk{};
        hsize_t room = largest_chunk / value_size;
        for (int d = checked(H5Pget_chunk(creation, H5S_MAX_RANK, chunk.data())) - 1; d >= 0; --d)
            room /= std::max<hsize_t>(chunk[static_cast<std::size_t>(d)], 1);
        if (room == 0)
            fail(join("has chunks of more than ", largest_chunk, " bytes"));
    }

    const OpenFile& file_;
    std::string name_;
};

/// Opens an attribute of the root group that is a single value.
Id open_attribute(const Item& item, hid_t file, const std::string& name)
{
    if (checked(H5Aexists(file, name.c_str())) == 0)
        item.fail("is missing");
    Id attribute(H5Aopen(file, name.c_str(), H5P_DEFAULT), H5Aclose);
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

} // namespace

struct Hdf5File::State : OpenFile
{
};

Hdf5File::Hdf5File(const std::filesystem::path& path)
{
    const std::uint64_t size = checked_file_size(path, largest_file);
    std::array<char, 8> signature{};
    std::ifstream(path, std::ios::binary).read(signature.data(), signature.size());
    if (std::string_view(signature.data(), signature.size()) != "\x89HDF\r\n\x1a\n")
        throw InvalidInput(path.string() + ": is no HDF5 file");
    Silence silence;
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
        std::vector<std::string> names;
        if (!item.exists())
            return names;
        const Id opened(H5Gopen2(state_->id, group.c_str(), H5P_DEFAULT), H5Gclose);
        const Id creation(H5Gget_create_plist(opened), H5Pclose);
        unsigned order = 0;
        checked(H5Pget_link_creation_order(creation, &order));
        const H5_index_t index = order & H5P_CRT_ORDER_INDEXED ? H5_INDEX_CRT_ORDER : H5_INDEX_NAME;
        H5G_info_t info;
        checked(H5Gget_info(opened, &info));
        for (hsize_t i = 0; i < info.nlinks; ++i) {
            std::array<char, longest_string + 1> name{};
            const ssize_t size = checked(H5Lget_name_by_idx(opened, ".", index, H5_ITER_INC, i,
                                                            name.data(), name.size(), H5P_DEFAULT));
            if (size > static_cast<ssize_t>(longest_string))
                item.fail("has a member with too long a name");
            names.emplace_back(name.data());
        }
        return names;
    });
}

Extents Hdf5File::extents(const std::string& name) const
{
    const Item item(*state_, name);
    return item.guarded([&] { return item.open().extents; });
}

RowMatrix Hdf5File::numbers(const std::string& name, const Extents& expected) const
{
    const Item item(*state_, name);
    RowMatrix values = item.guarded([&] {
        return item.read<RowMatrix>(expected, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, "float64");
    });
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
    return item.guarded(
        [&] { return item.read<IntMatrix>(expected, H5T_STD_I32LE, H5T_NATIVE_INT, "int32"); });
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
        std::string packed(size * static_cast<std::size_t>(stored.count), '\0');
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
    return item.guarded([&] { return checked(H5Aexists(state_->id, name.c_str())) > 0; });
}

std::string Hdf5File::text_attribute(const std::string& name) const
{
    const Item item(*state_, "attribute " + name);
    return item.guarded([&] {
        const Id attribute = open_attribute(item, state_->id, name);
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
        const Id attribute = open_attribute(item, state_->id, name);
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

} // namespace shape
