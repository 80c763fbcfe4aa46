// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <functional>
#include <optional>

#include "libshape/base/scratch_file.h"
#include "libshape/linalg/dense.h"

namespace shape::internal {

/// N rows of E numbers on disk, which come some rows at a time and go some columns at a time:
///
///     come   r0 ------------    go   c0 c1 c2 ..      on disk   all rows of c0 | all rows of c1 | ..
///            r1 ------------         |  |  |
///            ..                      |  |  |
///
/// What needs all rows, but columns one after another, measures each row once.
class ColumnStrips
{
public:
    /// Columns of a strip are a multiple of this, but of the last one. Not a power of two: rows of such a width fall
    /// on the same lines of a cache.
    static constexpr Eigen::Index unit = 504;

    /// Columns of a strip of so many rows: of at most 5 MB, as far as a unit allows.
    [[nodiscard]] static Eigen::Index width_for(Eigen::Index rows);

    /// None where the folder has no room for it (ScratchFile::make()).
    [[nodiscard]] static std::optional<ColumnStrips> make(const std::filesystem::path& folder,
                                                          Eigen::Index rows, Eigen::Index columns);

    /// Rows first, first + 1, ...
    /// @throws FileError if the disk fails.
    void put(Eigen::Index first, const RowMatrix& rows) const;

    /// Runs visit(first, columns) for all strips in their order; it may change the array.
    void for_each(const std::function<void(Eigen::Index first, RowMatrix& columns)>& visit) const;

private:
    ColumnStrips(ScratchFile file, Eigen::Index rows, Eigen::Index columns);

    void read(Eigen::Index first, RowMatrix& columns) const;

    ScratchFile file_;
    Eigen::Index rows_;
    Eigen::Index columns_;
    Eigen::Index width_;
};

} // namespace shape::internal
