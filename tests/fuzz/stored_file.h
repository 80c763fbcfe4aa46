// SPDX-License-Identifier: MIT

#pragma once

#include <hdf5.h>

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace shape::fuzz {

/// How numbers or strings are stored: one of those below, or strings of `size` bytes.
struct StoredType
{
    enum Kind
    {
        Double,
        Float,
        Int,
        Long,
        Unsigned,
        Byte,
        BigEndianDouble,
        String
    };
    Kind kind = Double;
    std::size_t size = 8;                      ///< [byte]
    H5T_cset_t character_set = H5T_CSET_ASCII; ///< Of strings.
    H5T_str_t padding = H5T_STR_NULLPAD;       ///< Likewise.
};

/// A dataset, or an attribute of the file.
struct StoredArray
{
    std::string name; ///< Of a dataset its path, "/modes/edge_lengths".
    bool is_attribute = false;
    StoredType type;
    std::vector<hsize_t> extents; ///< None of a single value.
    std::string bytes;            ///< Repeated, or cut, as the extents want.
    unsigned filters =
        1; ///< Bits: 1 checksum, 2 deflate, 4 chunks of one row; 8 contiguous instead.
};

/// What an HDF5 file holds, to be written with something changed by HDF5 itself: the library reads its own file without
/// harm, so what is tried is what we do with the content, without a child process for each file.
class StoredFile
{
public:
    explicit StoredFile(const std::filesystem::path& path);

    /// Every 12 bytes are a change: what (1), of which array (1), where (2), and a value (8). At most eight count.
    void change(std::string_view edits);

    /// Nothing is written if HDF5 refuses.
    /// @return Whether it was written.
    [[nodiscard]] bool write(const std::filesystem::path& path) const;

private:
    std::vector<StoredArray> arrays_;
};

/// Makes the checksums of superblock and object headers right, so that what was changed there is read and not only
/// refused. Whatever is not of the form is left alone.
void mend_checksums(std::string& file);

/// HDF5 makes and frees a table of 512 KiB for each file that it opens; let it keep that, and what else it can use again.
void keep_memory_of_hdf5();

} // namespace shape::fuzz
