// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <functional>
#include <span>
#include <vector>

#include "libshape/linalg/block_products.h"
#include "libshape/linalg/dense.h"
#include "libshape/statistics/pass_state_reader.h"

namespace shape::internal {

/// Inner products of N rows of E numbers about their mean, from rows that come tile by tile and of which
/// few are kept: in each pass some tiles are held, and every tile from the first of them on comes by.
///
///     pass 1   held 0 1 2   come 0 1 2 3 4 5 6        pass 2   held 3 4 5   come 3 4 5 6        ...
///
/// A tile of the products is a sum, over strips of columns, of products of two tiles, whatever is held:
/// neither the memory nor the number of threads changes a bit, nor whether rows or columns come. The rows are taken about the mean of the first tile, which keeps what
/// cancels small.
class TiledGram
{
public:
    /// @param held  Rows that may be kept at once; one tile is kept in any case.
    TiledGram(Eigen::Index rows, Eigen::Index columns, Eigen::Index held);

    /// Rows of a tile: a power of two in [4, 128], of about 12 MiB if it can be.
    [[nodiscard]] static Eigen::Index tile_rows(Eigen::Index columns);

    [[nodiscard]] Eigen::Index tile() const { return tile_; }
    [[nodiscard]] int pass_count() const;                       ///< From the first to the last.
    [[nodiscard]] Eigen::Index begin() const { return begin_; } ///< Where the next pass begins.
    [[nodiscard]] bool is_complete() const { return begin_ >= rows_; }

    /// The point about which the rows are taken; else the mean of the first tile.
    void start_at(const Eigen::VectorXd& origin);
    /// Takes the next tile of a pass, which it centres in place.
    void add(Eigen::Index first, RowMatrix& tile);
    void end_pass();

    // Where the rows are at hand column by column, no pass is needed.
    /// Takes the next columns of all rows, a multiple of ColumnStrips::unit of them but in the end, which it centres
    /// in place about their part of start_at().
    void add_columns(Eigen::Index first, RowMatrix& columns);
    void end_columns();

    // Where several processes share the tiles, each holds all that are held in a pass before it adds its own.
    [[nodiscard]] Eigen::Index held_end() const; ///< Rows [begin(), held_end()) are held.
    void hold(Eigen::Index first, RowMatrix& tile);
    /// What add() sums in this pass, 0 before it.
    [[nodiscard]] std::vector<std::span<double>> sums();
    /// Puts together what the processes have found in this pass.
    /// @param gather  Adds the numbers of all of them, of which all but one are 0.
    void gather(const std::function<void(std::span<double>)>& gather);

    // When complete.
    [[nodiscard]] Eigen::VectorXd mean() const;     ///< E.
    [[nodiscard]] Eigen::MatrixXd products() const; ///< N by N, symmetric.

    void release(PassState& state); ///< Between passes: hands over what restore() takes back.
    void restore(PassStateReader& state);

private:
    Eigen::Index rows_;
    Eigen::Index columns_;
    Eigen::Index tile_;
    Eigen::Index kept_rows_;
    Eigen::Index begin_ = 0;
    RowMatrix held_;
    RowMatrix products_; ///< The lower triangle of tiles, about shift_.
    Eigen::VectorXd shift_;
    Eigen::VectorXd sums_; ///< Of the rows about shift_.
};

/// Takes a vector from all rows and adds what is left to sums, each column in the order of the rows.
void centre_rows(Block rows, const Eigen::VectorXd& shift, Eigen::VectorXd* sums = nullptr);

} // namespace shape::internal
