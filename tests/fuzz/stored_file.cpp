// SPDX-License-Identifier: MIT

#include "tests/fuzz/stored_file.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <utility>

/// HDF5's own, which its headers keep to itself.
extern "C" std::uint32_t H5_checksum_metadata(const void* bytes, std::size_t size,
                                              std::uint32_t start);

namespace shape::fuzz {
namespace {

constexpr std::size_t most_bytes = 1 << 16; ///< Of an array: what is larger is not written.

/// An identifier, closed in the end.
class Handle
{
public:
    Handle(hid_t id, herr_t (*close)(hid_t)) : id_(id), close_(close) {}
    ~Handle()
    {
        if (id_ >= 0)
            close_(id_);
    }
    Handle(const Handle&) = delete;
    Handle& operator=(const Handle&) = delete;
    operator hid_t() const { return id_; } // NOLINT(google-explicit-constructor): as HDF5 takes it

private:
    hid_t id_;
    herr_t (*close_)(hid_t);
};

hid_t make_type(const StoredType& type)
{
    const std::array<hid_t, 7> numbers{H5T_IEEE_F64LE, H5T_IEEE_F32LE, H5T_STD_I32LE, H5T_STD_I64LE,
                                       H5T_STD_U64LE,  H5T_STD_U8LE,   H5T_IEEE_F64BE};
    if (type.kind != StoredType::String)
        return H5Tcopy(numbers[type.kind]);
    const hid_t made = H5Tcopy(H5T_C_S1);
    H5Tset_size(made, std::max<std::size_t>(type.size, 1));
    H5Tset_cset(made, type.character_set);
    H5Tset_strpad(made, type.padding);
    return made;
}

StoredType type_of(hid_t type)
{
    const std::size_t size = H5Tget_size(type);
    switch (H5Tget_class(type)) {
        case H5T_FLOAT:
            return {size == 8 ? StoredType::Double : StoredType::Float, size};
        case H5T_INTEGER:
            return {size == 4   ? StoredType::Int
                    : size == 8 ? StoredType::Long
                                : StoredType::Byte,
                    size};
        case H5T_STRING:
            return {StoredType::String, size, H5Tget_cset(type), H5Tget_strpad(type)};
        default:
            throw std::logic_error("a type that libshape does not write");
    }
}

StoredType type_of(unsigned number)
{
    constexpr std::array<std::size_t, 7> sizes{8, 4, 4, 8, 8, 1, 8};
    if (number % 8 < sizes.size())
        return {static_cast<StoredType::Kind>(number % 8), sizes[number % 8]};
    return {StoredType::String, 1 + number / 8 % 64};
}

std::vector<hsize_t> extents_of(hid_t space)
{
    std::vector<hsize_t> extents(static_cast<std::size_t>(H5Sget_simple_extent_ndims(space)));
    if (!extents.empty())
        H5Sget_simple_extent_dims(space, extents.data(), nullptr);
    return extents;
}

std::size_t bytes_of(const StoredArray& array)
{
    std::size_t bytes = array.type.size;
    for (const hsize_t extent : array.extents)
        bytes = extent > most_bytes ? most_bytes + 1
                                    : std::min<std::size_t>(bytes * extent, most_bytes + 1);
    return bytes;
}

StoredArray read_array(hid_t id, const std::string& name, bool is_attribute)
{
    const Handle type(is_attribute ? H5Aget_type(id) : H5Dget_type(id), H5Tclose);
    const Handle space(is_attribute ? H5Aget_space(id) : H5Dget_space(id), H5Sclose);
    StoredArray array{name, is_attribute, type_of(type), extents_of(space), {}, 1};
    array.bytes.resize(bytes_of(array));
    const Handle memory(make_type(array.type), H5Tclose);
    const herr_t result =
        is_attribute ? H5Aread(id, memory, array.bytes.data())
                     : H5Dread(id, memory, H5S_ALL, H5S_ALL, H5P_DEFAULT, array.bytes.data());
    if (result < 0)
        throw std::logic_error("cannot read " + name);
    return array;
}

/// Groups before the datasets in them.
void make_groups(hid_t file, const std::string& path)
{
    const Handle list(H5Pcreate(H5P_GROUP_CREATE), H5Pclose);
    H5Pset_link_creation_order(list, H5P_CRT_ORDER_TRACKED | H5P_CRT_ORDER_INDEXED);
    for (std::size_t slash = path.find('/', 1); slash != std::string::npos;
         slash = path.find('/', slash + 1)) {
        const std::string group = path.substr(0, slash);
        if (H5Lexists(file, group.c_str(), H5P_DEFAULT) == 0)
            (void)Handle(H5Gcreate2(file, group.c_str(), H5P_DEFAULT, list, H5P_DEFAULT), H5Gclose);
    }
}

hid_t make_dataset(hid_t file, const StoredArray& array, hid_t type, hid_t space)
{
    make_groups(file, array.name);
    const Handle list(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
    if (array.extents.empty()) {
        H5Pset_layout(list, H5D_COMPACT);
    } else if ((array.filters & 8U) == 0 && bytes_of(array) > 0) {
        std::vector<hsize_t> chunk = array.extents;
        if ((array.filters & 4U) != 0)
            chunk[0] = 1;
        H5Pset_chunk(list, static_cast<int>(chunk.size()), chunk.data());
        if ((array.filters & 2U) != 0)
            H5Pset_deflate(list, 1);
        if ((array.filters & 1U) != 0)
            H5Pset_fletcher32(list);
    }
    return H5Dcreate2(file, array.name.c_str(), type, space, H5P_DEFAULT, list, H5P_DEFAULT);
}

void write_array(hid_t file, const StoredArray& array)
{
    const std::size_t size = bytes_of(array);
    if (size > most_bytes)
        return;
    std::string bytes(size, '\0');
    for (std::size_t i = 0; i < size && !array.bytes.empty(); ++i)
        bytes[i] = array.bytes[i % array.bytes.size()];
    const Handle type(make_type(array.type), H5Tclose);
    const Handle space(array.extents.empty()
                           ? H5Screate(H5S_SCALAR)
                           : H5Screate_simple(static_cast<int>(array.extents.size()),
                                              array.extents.data(), nullptr),
                       H5Sclose);
    if (array.is_attribute) {
        const Handle made(
            H5Acreate2(file, array.name.c_str(), type, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
        if (made >= 0)
            H5Awrite(made, type, bytes.data());
        return;
    }
    const Handle made(make_dataset(file, array, type, space), H5Dclose);
    if (made >= 0 && size > 0)
        H5Dwrite(made, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, bytes.data());
}

struct Edit
{
    unsigned what;
    unsigned which;
    unsigned where;
    std::string value; ///< 8 bytes.
};

void overwrite(StoredArray& array, const Edit& edit)
{
    for (std::size_t i = 0; i < std::min(edit.value.size(), array.bytes.size()); ++i)
        array.bytes[(edit.where * std::min<std::size_t>(array.type.size, 8) + i) %
                    array.bytes.size()] = edit.value[i];
}

void resize(StoredArray& array, const Edit& edit)
{
    if (array.extents.empty())
        return;
    hsize_t& extent = array.extents[edit.where % array.extents.size()];
    const std::array<hsize_t, 6> sizes{0, 1, extent - 1, extent + 1, 2 * extent, edit.where};
    extent = sizes[static_cast<unsigned char>(edit.value[0]) % sizes.size()];
}

void change_rank(StoredArray& array, const Edit& edit)
{
    if (array.extents.size() < 4 && edit.where % 2 == 0)
        array.extents.insert(
            array.extents.begin() +
                static_cast<std::ptrdiff_t>(edit.where / 2 % (array.extents.size() + 1)),
            1 + static_cast<unsigned char>(edit.value[0]) % 3U);
    else if (!array.extents.empty())
        array.extents.pop_back();
}

constexpr std::size_t checksum_size = 4;

unsigned byte_at(std::string_view bytes, std::size_t i)
{
    return static_cast<unsigned char>(bytes[i]);
}

/// The checksum behind bytes [begin, end).
void mend(std::string& file, std::size_t begin, std::size_t end)
{
    if (end < begin || end > file.size() || file.size() - end < checksum_size)
        return;
    const std::uint32_t sum = H5_checksum_metadata(file.data() + begin, end - begin, 0);
    for (std::size_t i = 0; i < checksum_size; ++i)
        file[end + i] = static_cast<char>(sum >> (8 * i));
}

/// Where the messages of an object header of version 2 end; 0 if it is cut.
std::size_t end_of_header(std::string_view file, std::size_t begin)
{
    constexpr std::size_t flags_at = 5;
    if (file.size() - begin <= flags_at)
        return 0;
    const unsigned flags = byte_at(file, begin + flags_at);
    const std::size_t times = (flags & 0x20U) != 0 ? 16 : 0;
    const std::size_t phases = (flags & 0x10U) != 0 ? 4 : 0;
    const std::size_t size_at = begin + flags_at + 1 + times + phases;
    const std::size_t size_bytes = std::size_t{1} << (flags & 3U);
    if (file.size() < size_at + size_bytes)
        return 0;
    std::size_t size = 0;
    for (std::size_t i = size_bytes; i-- > 0;)
        size = size << 8 | byte_at(file, size_at + i);
    return size > file.size() ? 0 : size_at + size_bytes + size;
}

} // namespace

void mend_checksums(std::string& file)
{
    constexpr std::size_t superblock_size = 44;
    mend(file, 0, superblock_size);
    for (std::size_t at = file.find("OHDR"); at != std::string::npos;
         at = file.find("OHDR", at + 1))
        mend(file, at, end_of_header(file, at));
}

void keep_memory_of_hdf5()
{
    H5set_free_list_limits(-1, -1, -1, -1, -1, -1);
}

StoredFile::StoredFile(const std::filesystem::path& path)
{
    const Handle file(H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose);
    if (file < 0)
        throw std::runtime_error("cannot open " + path.string());
    const auto visit_attribute = [](hid_t object, const char* name, const H5A_info_t*,
                                    void* data) -> herr_t {
        const Handle attribute(H5Aopen(object, name, H5P_DEFAULT), H5Aclose);
        static_cast<std::vector<StoredArray>*>(data)->push_back(read_array(attribute, name, true));
        return 0;
    };
    H5Aiterate2(file, H5_INDEX_NAME, H5_ITER_INC, nullptr, visit_attribute, &arrays_);
    const auto visit_link = [](hid_t root, const char* name, const H5L_info_t*,
                               void* data) -> herr_t {
        const Handle object(H5Oopen(root, name, H5P_DEFAULT), H5Oclose);
        if (H5Iget_type(object) == H5I_DATASET)
            static_cast<std::vector<StoredArray>*>(data)->push_back(
                read_array(object, std::string("/").append(name), false));
        return 0;
    };
    H5Lvisit(file, H5_INDEX_NAME, H5_ITER_INC, visit_link, &arrays_);
}

void StoredFile::change(std::string_view edits)
{
    constexpr std::size_t size = 12;
    for (int k = 0; k < 8 && edits.size() >= size && !arrays_.empty();
         ++k, edits.remove_prefix(size)) {
        const auto byte = [&](std::size_t i) {
            return static_cast<unsigned>(static_cast<unsigned char>(edits[i]));
        };
        const Edit edit{byte(0), byte(1), byte(2) + 256 * byte(3), std::string(edits.substr(4, 8))};
        const std::size_t which = edit.which % arrays_.size();
        StoredArray& array = arrays_[which];
        switch (edit.what % 8) {
            case 0:
            case 1:
                overwrite(array, edit);
                break;
            case 2:
                resize(array, edit);
                break;
            case 3:
                change_rank(array, edit);
                break;
            case 4:
                array.type = type_of(edit.where);
                break;
            case 5:
                arrays_.erase(arrays_.begin() + static_cast<std::ptrdiff_t>(which));
                break;
            case 6:
                std::swap(array.name, arrays_[edit.where % arrays_.size()].name);
                break;
            default:
                array.filters = edit.where;
                break;
        }
    }
}

bool StoredFile::write(const std::filesystem::path& path) const
{
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
    const Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
    H5Pset_libver_bounds(access, H5F_LIBVER_LATEST, H5F_LIBVER_LATEST);
    const Handle creation(H5Pcreate(H5P_FILE_CREATE), H5Pclose);
    H5Pset_link_creation_order(creation, H5P_CRT_ORDER_TRACKED | H5P_CRT_ORDER_INDEXED);
    const Handle file(H5Fcreate(path.c_str(), H5F_ACC_TRUNC, creation, access), H5Fclose);
    if (file < 0)
        return false;
    for (const StoredArray& array : arrays_)
        write_array(file, array);
    return true;
}

} // namespace shape::fuzz
