// SPDX-License-Identifier: MIT

#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "libshape/io/hdf5/stored_dataset.h"

namespace shape::internal {

/// A value, or why there is none: the rule that the file breaks, for messages.
template <class Value>
struct Found
{
    Value value{};
    std::string refusal{};
};

struct StoredAttribute
{
    std::string name;
    Found<std::string> text;
    Found<std::int64_t> integer;
};

/// What a group lists.
struct StoredObject
{
    std::string refusal; ///< Why it is not looked at: a link to elsewhere.
    Found<StoredDataset> dataset;
};

/// What an HDF5 file holds, as plain values: all of the two upper levels but its arrays of doubles, of
/// which it says where they stand. Everything that HDF5 is asked about a file is asked here, once; so it can be
/// asked in a process of its own (isolation.h), and whoever reads the file needs HDF5 no more.
struct FileContent
{
    std::string refusal;                                           ///< Why HDF5 does not open it.
    Found<std::vector<StoredAttribute>> attributes;                ///< Of the root group.
    std::map<std::string, Found<std::vector<std::string>>> groups; ///< "/group": names, in order.
    std::map<std::string, StoredObject> objects;                   ///< "/group/name".
    std::string values; ///< Of all datasets, and chunks of doubles: bytes one after the other.
};

/// Asks HDF5. Memory: at most four times the size of the file, and some for each of its members.
/// @param file_size  [byte]
/// @throws std::bad_alloc where the system limits the memory.
[[nodiscard]] FileContent read_content(const std::filesystem::path& path, std::uint64_t file_size);

} // namespace shape::internal
