// SPDX-License-Identifier: MIT

#include "libshape/statistics/inner_products.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "libshape/base/threads.h"
#include "libshape/statistics/distance_matrix.h"
#include "libshape/statistics/mean.h"

namespace shape {

using Eigen::Index;

Eigen::MatrixXd inner_products(const RowMatrix& data)
{
    // Fixed tiles, each summed by one thread.
    constexpr Index tile = 96;
    std::vector<std::pair<Index, Index>> tiles;
    for (Index row = 0; row < data.rows(); row += tile)
        for (Index column = 0; column <= row; column += tile)
            tiles.emplace_back(row, column);
    Eigen::MatrixXd products(data.rows(), data.rows());
    parallel_for(tiles.size(), 1, [&](std::size_t begin, std::size_t) {
        const auto [row, column] = tiles[begin];
        const Index rows = std::min(tile, data.rows() - row);
        const Index columns = std::min(tile, data.rows() - column);
        products.block(row, column, rows, columns).noalias() =
            data.middleRows(row, rows) * data.middleRows(column, columns).transpose();
    });
    products.triangularView<Eigen::StrictlyUpper>() = products.transpose();
    return products;
}

Eigen::MatrixXd centred_inner_products(RowMatrix data)
{
    data.rowwise() -= mean_of_rows(data).transpose();
    return inner_products(data);
}

Eigen::MatrixXd inner_products_of_distances(const Eigen::MatrixXd& distances)
{
    check_distances(distances);
    Eigen::MatrixXd products = -0.5 * distances.cwiseAbs2();
    products.rowwise() -= products.colwise().mean().eval();
    products.colwise() -= products.rowwise().mean().eval();
    return products;
}

} // namespace shape
