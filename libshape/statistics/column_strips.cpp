// SPDX-License-Identifier: MIT

#include "libshape/statistics/column_strips.h"

#include <algorithm>
#include <mutex>
#include <utility>

#include "libshape/base/to_size.h"
#include "libshape/linalg/strips.h"

namespace shape::internal {

using Eigen::Index;

Index ColumnStrips::width_for(Index rows)
{
    constexpr Index bytes = 5'000'000;
    const Index fit =
        bytes / (static_cast<Index>(sizeof(double)) * unit * std::max<Index>(rows, 1));
    return unit * std::clamp<Index>(fit, 1, 4);
}

std::optional<ColumnStrips> ColumnStrips::make(const std::filesystem::path& folder, Index rows,
                                               Index columns)
{
    auto file = ScratchFile::make(folder, sizeof(double) * to_size(rows) * to_size(columns));
    if (!file)
        return std::nullopt;
    return ColumnStrips(std::move(*file), rows, columns);
}

ColumnStrips::ColumnStrips(ScratchFile file, Index rows, Index columns)
    : file_(std::move(file)), rows_(rows), columns_(columns), width_(width_for(rows))
{
}

void ColumnStrips::put(Index first, const RowMatrix& rows) const
{
    std::mutex writing; // the kernel lets one write to a file at a time, the others spin
    for_strips(columns_, width_, [&](Index column, Index count) {
        const RowMatrix part = rows.middleCols(column, count);
        const std::lock_guard lock(writing);
        file_.write(to_size(column * rows_ + first * part.cols()),
                    {part.data(), to_size(part.size())});
    });
}

void ColumnStrips::read(Index first, RowMatrix& columns) const
{
    columns.resize(rows_, std::min(width_, columns_ - first));
    file_.read(to_size(first * rows_), {columns.data(), to_size(columns.size())});
}

void ColumnStrips::for_each(const std::function<void(Index, RowMatrix&)>& visit) const
{
    RowMatrix columns; // kept: fresh memory costs more than reading
    for (Index first = 0; first < columns_; first += width_) {
        read(first, columns);
        visit(first, columns);
    }
}

} // namespace shape::internal
