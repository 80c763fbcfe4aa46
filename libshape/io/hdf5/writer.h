// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "libshape/io/hdf5/extents.h"

namespace shape::internal {

/// Numbers that are made when they are written, so that they need not be held together: those of
/// one index of the first extent, in row-major order. Called once for each, in order.
using Hdf5Rows = std::function<void(Eigen::Index row, std::span<double> numbers)>;

/// A dataset to write; its values, in row-major order, stay with the caller.
struct Hdf5Dataset
{
    std::string name; ///< "/group/name".
    Extents extents;
    std::variant<std::span<const double>, std::span<const float>, std::span<const int>,
                 std::span<const std::string>, Hdf5Rows>
        values;
    bool compress = false; ///< Doubles are stored with shuffle and deflate, below the checksum.
};

using Hdf5Value = std::variant<std::string, std::int64_t, double>;

/// What an HDF5 file holds: attributes of the root group, and datasets.
struct Hdf5Content
{
    std::vector<std::pair<std::string, Hdf5Value>> attributes;
    std::vector<Hdf5Dataset> datasets;
    /// Attributes of groups of datasets: the group, then name and value.
    std::vector<std::pair<std::string, std::pair<std::string, Hdf5Value>>> group_attributes = {};
    /// As the oldest readers take it: contiguous, without checksums, strings that end in NUL.
    bool plain = false;
};

/// Writes a file beside the target, reads every dataset back and compares it bit by bit (numbers that
/// were made, by a hash of 64 bits), and renames it into place. Equal contents give equal bytes.
/// Memory: beside the content a few MiB.
/// @param before_renaming  As of write_file_atomically().
/// @throws FileError if it cannot be written.
/// @throws InvalidInput if a string is not UTF-8, holds a NUL or has more than 4096 bytes, or a
///     name is empty or ".".
void write_hdf5(const std::filesystem::path& path, const Hdf5Content& content,
                const std::function<void()>& before_renaming = {});

} // namespace shape::internal
