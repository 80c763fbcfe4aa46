// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <functional>
#include <optional>

#include "libshape/base/scratch_file.h"
#include "libshape/linalg/dense.h"

namespace shape::internal {

/// N rows of E numbers on disc, which come some rows at a time and go some columns at a time:
///
///     come   r0 ------------    go   c0 c1 c2 ..      on disc   all rows of c0 | all rows of c1 | ..
///            r1 ------------         |  |  |
///            ..                      |  |  |
///
/// What needs all rows, but columns one after another, measures each row once.
class ColumnStrips
{
public:
    static constexpr Eigen::Index width = 2048; ///< Columns of a strip; the last one has fewer.

    /// None where the folder has no room for it (ScratchFile::make()).
    [[nodiscard]] static std::optional<ColumnStrips> make(const std::filesystem::path& folder,
                                                          Eigen::Index rows, Eigen::Index columns);

    /// Rows first, first + 1, ...
    /// @throws FileError if the disc fails.
    void put(Eigen::Index first, const RowMatrix& rows) const;

    /// Runs visit(first, columns) for all strips, or those that are wanted; some at once, each in a thread: as
    /// many as 16 MiB hold. visit() may change the array.
    using Visit = std::function<void(Eigen::Index first, RowMatrix& columns)>;
    using IsWanted = std::function<bool(Eigen::Index first, Eigen::Index count)>;
    void for_each(const Visit& visit) const;
    void for_each(const IsWanted& is_wanted, const Visit& visit) const;

    /// The same in their order, one at a time.
    void for_each_in_order(const Visit& visit) const;

private:
    ColumnStrips(ScratchFile file, Eigen::Index rows, Eigen::Index columns);

    void read(Eigen::Index first, RowMatrix& columns) const;

    ScratchFile file_;
    Eigen::Index rows_;
    Eigen::Index columns_;
};

} // namespace shape::internal
