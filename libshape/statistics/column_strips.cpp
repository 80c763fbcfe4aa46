// SPDX-License-Identifier: MIT

#include "libshape/statistics/column_strips.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "libshape/base/threads.h"
#include "libshape/base/to_size.h"

namespace shape::internal {

using Eigen::Index;

std::optional<ColumnStrips> ColumnStrips::make(const std::filesystem::path& folder, Index rows,
                                               Index columns)
{
    auto file = ScratchFile::make(folder, sizeof(double) * to_size(rows) * to_size(columns));
    if (!file)
        return std::nullopt;
    return ColumnStrips(std::move(*file), rows, columns);
}

ColumnStrips::ColumnStrips(ScratchFile file, Index rows, Index columns)
    : file_(std::move(file)), rows_(rows), columns_(columns)
{
}

void ColumnStrips::put(Index first, const RowMatrix& rows) const
{
    parallel_for(to_size(columns_), to_size(width), [&](std::size_t begin, std::size_t end) {
        const auto column = static_cast<Index>(begin);
        const RowMatrix part = rows.middleCols(column, static_cast<Index>(end - begin));
        file_.write(to_size(column * rows_ + first * part.cols()),
                    {part.data(), to_size(part.size())});
    });
}

void ColumnStrips::read(Index first, RowMatrix& columns) const
{
    columns.resize(rows_, std::min(width, columns_ - first));
    file_.read(to_size(first * rows_), {columns.data(), to_size(columns.size())});
}

void ColumnStrips::for_each(const Visit& visit) const
{
    for_each([](Index, Index) { return true; }, visit);
}

void ColumnStrips::for_each(const IsWanted& is_wanted, const Visit& visit) const
{
    const Index bytes = static_cast<Index>(sizeof(double)) * rows_ * width;
    const Index at_once = std::clamp<Index>((Index{16} << 20) / bytes, 1, thread_count());
    std::vector<RowMatrix> columns(to_size(at_once)); // kept: fresh memory costs more than reading
    for (Index first = 0; first < columns_; first += at_once * width)
        parallel_for(to_size(std::min(at_once * width, columns_ - first)), to_size(width),
                     [&](std::size_t begin, std::size_t end) {
                         const Index own = first + static_cast<Index>(begin);
                         if (!is_wanted(own, static_cast<Index>(end - begin)))
                             return;
                         RowMatrix& kept = columns[begin / to_size(width)];
                         read(own, kept);
                         visit(own, kept);
                     });
}

void ColumnStrips::for_each_in_order(const Visit& visit) const
{
    RowMatrix columns;
    for (Index first = 0; first < columns_; first += width) {
        read(first, columns);
        visit(first, columns);
    }
}

} // namespace shape::internal
