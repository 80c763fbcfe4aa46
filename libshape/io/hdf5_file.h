// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "libshape/linalg/dense.h"

// The part of HDF5 that the files of this library use. Internal to io/; docs/formats.md says what
// is written and what is refused.

namespace shape {

/// Extents of a dataset; none for a single value.
using Extents = std::vector<Eigen::Index>;

/// In expected extents: any length > 0.
inline constexpr Eigen::Index any_length = -1;

/// Numbers that are made when they are written, so that they need not be held together: those of
/// one index of the first extent, in row-major order. Equal calls must give equal numbers.
using Hdf5Rows = std::function<void(Eigen::Index row, std::span<double> numbers)>;

/// A dataset to write; its values, in row-major order, stay with the caller.
struct Hdf5Dataset
{
    std::string name; ///< "/group/name".
    Extents extents;
    std::variant<std::span<const double>, std::span<const int>, std::span<const std::string>,
                 Hdf5Rows>
        values;
};

using Hdf5Value = std::variant<std::string, std::int64_t, double>;

/// What an HDF5 file holds: attributes of the root group, and datasets.
struct Hdf5Content
{
    std::vector<std::pair<std::string, Hdf5Value>> attributes;
    std::vector<Hdf5Dataset> datasets;
};

/// Writes a file beside the target, reads every dataset back and compares it bit by bit, and renames
/// it into place. Equal contents give equal bytes.
/// @throws FileError if it cannot be written.
/// @throws InvalidInput if a string is not UTF-8, holds a NUL or has more than 4096 bytes, or a
///     name is empty or ".".
void write_hdf5(const std::filesystem::path& path, const Hdf5Content& content);

/// An HDF5 file open for reading. Every member throws InvalidInput naming file, dataset and rule.
///
/// Only what write_hdf5() could have written is read: plain datasets in plain groups, of 32-bit
/// integers, doubles and fixed-length UTF-8 strings, with no filter but the checksum, no larger than
/// the file.
class Hdf5File
{
public:
    /// @throws FileError if the file cannot be read; LimitExceeded if it is larger than 8 GiB.
    explicit Hdf5File(const std::filesystem::path& path);
    ~Hdf5File();

    [[nodiscard]] const std::string& path() const;

    [[nodiscard]] bool has(const std::string& name) const;
    [[nodiscard]] std::vector<std::string> members(const std::string& group) const;
    [[nodiscard]] Extents extents(const std::string& name) const;

    /// Finite numbers: the first extent as rows, the others together as columns.
    [[nodiscard]] RowMatrix numbers(const std::string& name, const Extents& expected) const;
    [[nodiscard]] Eigen::Matrix<int, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> integers(
        const std::string& name, const Extents& expected) const;
    [[nodiscard]] std::vector<std::string> strings(const std::string& name,
                                                   Eigen::Index expected) const;

    [[nodiscard]] bool has_attribute(const std::string& name) const;
    [[nodiscard]] std::string text_attribute(const std::string& name) const;
    [[nodiscard]] std::int64_t integer_attribute(const std::string& name) const;

    /// @throws InvalidInput always.
    [[noreturn]] void fail(const std::string& name, const std::string& rule) const;

private:
    struct State;
    std::unique_ptr<State> state_;
};

} // namespace shape
