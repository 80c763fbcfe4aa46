// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "libshape/io/hdf5/extents.h"
#include "libshape/io/hdf5/stored_rows.h"
#include "libshape/linalg/dense.h"

namespace shape::internal {

/// An HDF5 file for reading. Every member throws InvalidInput naming file, dataset and rule. HDF5 itself is
/// done with it once it is constructed (file_content.h).
///
/// Only what write_hdf5() (writer.h) could have written is read: plain datasets in plain groups, of 32-bit
/// integers, doubles and fixed-length UTF-8 strings, with no filter but the checksum and, below it, the
/// lossless compression of doubles; no larger than the file. Doubles are read past HDF5
/// (stored_rows.h).
class Hdf5File
{
public:
    /// @throws FileError if the file cannot be read.
    /// @throws InvalidInput if it is no HDF5 file, or as of isolation.h.
    explicit Hdf5File(const std::filesystem::path& path);
    ~Hdf5File();

    [[nodiscard]] const std::string& path() const;

    [[nodiscard]] bool has(const std::string& name) const;
    [[nodiscard]] std::vector<std::string> members(const std::string& group) const;
    [[nodiscard]] bool is_compressed(const std::string& name) const; ///< A dataset.

    /// Rows of a dataset of doubles, to be read when they are needed.
    [[nodiscard]] StoredRows rows(const std::string& name, const Extents& expected) const;

    /// Finite numbers: the first extent as rows, the others together as columns.
    /// @throws LimitExceeded if they take more than 8 GiB.
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

} // namespace shape::internal
