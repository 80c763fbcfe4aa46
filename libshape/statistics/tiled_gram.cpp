// SPDX-License-Identifier: MIT

#include "libshape/statistics/tiled_gram.h"

#include <algorithm>
#include <bit>
#include <utility>

#include "libshape/base/threads.h"
#include "libshape/base/to_size.h"
#include "libshape/linalg/block_products.h"
#include "libshape/linalg/strips.h"
#include "libshape/statistics/column_strips.h"

namespace shape::internal {

using Eigen::Index;

void centre_rows(Block rows, const Eigen::VectorXd& shift, Eigen::VectorXd* sums)
{
    for_strips(rows.cols(), 4096, [&](Index first, Index count) {
        for (Index i = 0; i < rows.rows(); ++i) {
            rows.row(i).segment(first, count) -= shift.segment(first, count).transpose();
            if (sums != nullptr)
                sums->segment(first, count) += rows.row(i).segment(first, count).transpose();
        }
    });
}

Index TiledGram::tile_rows(Index columns)
{
    constexpr Index bytes = Index{12} << 20;
    const Index fit = bytes / (static_cast<Index>(sizeof(double)) * std::max<Index>(columns, 1));
    return std::clamp<Index>(static_cast<Index>(std::bit_floor(to_size(fit))), 4, 128);
}

TiledGram::TiledGram(Index rows, Index columns, Index held)
    : rows_(rows),
      columns_(columns),
      tile_(tile_rows(columns)),
      kept_rows_(std::min(rows, std::max<Index>(held / tile_, 1) * tile_)),
      products_(RowMatrix::Zero(rows, rows)),
      sums_(Eigen::VectorXd::Zero(columns))
{
}

int TiledGram::pass_count() const
{
    return static_cast<int>((rows_ + kept_rows_ - 1) / kept_rows_);
}

void TiledGram::start_at(const Eigen::VectorXd& origin)
{
    shift_ = origin;
}

Index TiledGram::held_end() const
{
    return std::min(rows_, begin_ + kept_rows_);
}

std::vector<std::span<double>> TiledGram::sums()
{
    if (begin_ > 0)
        return {};
    return {{sums_.data(), to_size(sums_.size())}};
}

void TiledGram::gather(const std::function<void(std::span<double>)>& gather)
{
    RowMatrix found = products_.middleCols(begin_, held_end() - begin_);
    gather({found.data(), to_size(found.size())});
    products_.middleCols(begin_, found.cols()) = found;
}

void TiledGram::hold(Index first, RowMatrix& tile)
{
    if (held_.rows() == 0)
        held_.resize(kept_rows_, columns_);
    centre_rows(tile, shift_);
    held_.middleRows(first - begin_, tile.rows()) = tile;
}

void TiledGram::add(Index first, RowMatrix& tile)
{
    if (held_.rows() == 0)
        held_.resize(kept_rows_, columns_);
    if (shift_.size() == 0)
        shift_ = tile.colwise().mean().transpose();
    centre_rows(tile, shift_, begin_ == 0 ? &sums_ : nullptr);
    if (first < held_end())
        held_.middleRows(first - begin_, tile.rows()) = tile;
    const Index partners = (std::min(first + 1, held_end()) - begin_ + tile_ - 1) / tile_;
    parallel_for(to_size(partners), 1, [&](std::size_t p, std::size_t) {
        const Index column = begin_ + static_cast<Index>(p) * tile_;
        const Index columns = std::min(tile_, held_end() - column);
        for (Index begin = 0; begin < columns_; begin += ColumnStrips::unit) {
            const Index count = std::min(ColumnStrips::unit, columns_ - begin);
            add_product_with_rows(tile.middleCols(begin, count),
                                  held_.block(column - begin_, begin, columns, count),
                                  products_.block(first, column, tile.rows(), columns));
        }
    });
}

void TiledGram::add_columns(Index first, RowMatrix& columns)
{
    Eigen::VectorXd sums = Eigen::VectorXd::Zero(columns.cols());
    centre_rows(columns, shift_.segment(first, columns.cols()), &sums);
    sums_.segment(first, columns.cols()) = sums;
    // The fewer rows are taken together, the more comes from the third cache; more than few_rows would be
    // multiplied another way.
    const Index height = std::max(tile_, few_rows);
    parallel_for(to_size(rows_), to_size(height), [&](std::size_t first_row, std::size_t) {
        const auto row = static_cast<Index>(first_row);
        for (Index begin = 0; begin < columns.cols(); begin += ColumnStrips::unit) {
            const Index count = std::min(ColumnStrips::unit, columns.cols() - begin);
            const auto part = [&](Index i) {
                return columns.block(i, begin, std::min(height, rows_ - i), count);
            };
            for (Index other = 0; other <= row; other += height)
                add_product_with_rows(
                    part(row), part(other),
                    products_.block(row, other, part(row).rows(), part(other).rows()));
        }
    });
}

void TiledGram::end_columns()
{
    begin_ = rows_;
}

void TiledGram::end_pass()
{
    begin_ = std::min(rows_, begin_ + kept_rows_);
    if (is_complete())
        held_.resize(0, 0);
}

Eigen::VectorXd TiledGram::mean() const
{
    return shift_ + sums_ / static_cast<double>(rows_);
}

Eigen::MatrixXd TiledGram::products() const
{
    Eigen::MatrixXd products = products_.triangularView<Eigen::Lower>();
    products.triangularView<Eigen::StrictlyUpper>() = products.transpose();
    const Eigen::VectorXd means = products.rowwise().mean();
    products.colwise() -= means;
    products.rowwise() -= means.transpose();
    products.array() += means.mean();
    products.triangularView<Eigen::StrictlyUpper>() = products.transpose(); // to the bit
    return products;
}

void TiledGram::release(PassState& state)
{
    state.numbers.push_back(begin_);
    state.arrays.push_back(std::move(products_));
    state.arrays.emplace_back(shift_.transpose());
    state.arrays.emplace_back(sums_.transpose());
}

void TiledGram::restore(PassStateReader& state)
{
    begin_ = static_cast<Index>(state.number());
    products_ = state.array(rows_, rows_);
    shift_ = state.vector(columns_);
    sums_ = state.vector(columns_);
}

} // namespace shape::internal
