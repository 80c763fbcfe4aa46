// SPDX-License-Identifier: MIT

#include "libshape/model/streamed_distances.h"

#include <algorithm>
#include <cmath>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/require.h"
#include "libshape/base/threads.h"
#include "libshape/base/to_size.h"
#include "libshape/linalg/block_products.h"
#include "libshape/model/mesh_passes.h"
#include "libshape/model/streamed_fit.h"
#include "libshape/statistics/column_signs.h"
#include "libshape/statistics/tiled_gram.h"

namespace shape {
using namespace internal;
namespace {

using Eigen::Index;

/// Distances of the rows of a from those of b. From inner products; where those would leave fewer than ten
/// digits of a distance, from the difference.
RowMatrix distances_between(const ConstBlock& a, const ConstBlock& b)
{
    constexpr double cancelled = 1e-5; // of squares whose rounding is 1e-15
    const Eigen::VectorXd own = a.rowwise().squaredNorm();
    const Eigen::VectorXd others = b.rowwise().squaredNorm();
    RowMatrix c = RowMatrix::Zero(a.rows(), b.rows());
    add_product_with_rows(a, b, c);
    for (Index i = 0; i < a.rows(); ++i)
        for (Index j = 0; j < b.rows(); ++j) {
            const double both = own[i] + others[j];
            const double square = both - 2.0 * c(i, j);
            c(i, j) = square > cancelled * both ? std::sqrt(square) : (a.row(i) - b.row(j)).norm();
        }
    return c;
}

/// The distances of two tiles from each other, in the order in which they lie: so there and back are
/// the same bits.
RowMatrix distances_of_tiles(const ConstBlock& a, Index first_a, const ConstBlock& b, Index first_b)
{
    if (first_a > first_b)
        return distances_between(b, a).transpose();
    RowMatrix result = distances_between(a, b);
    if (first_a == first_b)
        result.triangularView<Eigen::StrictlyUpper>() = result.transpose();
    return result;
}

} // namespace

void check(const StreamedDistancesOptions& options)
{
    check(options.space);
    check(options.ranks);
}

ShapeSpace for_each_distance_row(
    const MeshStream& meshes, const StreamedDistancesOptions& options,
    const std::function<void(Index first, const RowMatrix& distances)>& visit)
{
    check(options);
    const Index count = meshes.size();
    if (count < 2)
        throw InvalidInput(join("distances need at least 2 meshes, there are ", count));
    MeshPasses passes(meshes, options.space, options.memory, options.progress, options.ranks);
    const Index tile = std::min(TiledGram::tile_rows(passes.dimension()), count);
    const std::uint64_t row = sizeof(double) * to_size(passes.dimension() + count);
    const std::uint64_t fit = passes.memory() / 2 / row;
    if (fit < to_size(tile))
        throw LimitExceeded(join(tile, " meshes and their distances take ",
                                 (to_size(tile) * row >> 20) + 1,
                                 " MiB, which is more than half of the ", passes.memory() >> 20,
                                 " MiB allowed; allow more memory"));
    const Index step = std::min(count, static_cast<Index>(fit) / tile * tile);
    Eigen::VectorXd origin; // about which inner products are small
    const auto encode = [&](const Collection& block, RowMatrix& rows) {
        passes.encode(block, rows);
        if (origin.size() == 0)
            origin = rows.colwise().mean().transpose();
        centre_rows(rows, origin);
    };
    for (Index begin = 0; begin < count; begin += step) {
        const Index held_count = std::min(step, count - begin);
        RowMatrix held(held_count, passes.dimension());
        RowMatrix distances = RowMatrix::Zero(held_count, count);
        passes.show({begin, begin + held_count, tile},
                    [&](Index first, const Collection& block, RowMatrix& rows) {
                        encode(block, rows);
                        held.middleRows(first - begin, rows.rows()) = rows;
                    });
        passes.run("distances", passes.all(tile),
                   [&](Index first, const Collection& block, RowMatrix& rows) {
                       encode(block, rows);
                       parallel_for(to_size((held_count + tile - 1) / tile), 1,
                                    [&](std::size_t t, std::size_t) {
                                        const Index row_begin = static_cast<Index>(t) * tile;
                                        const Index some = std::min(tile, held_count - row_begin);
                                        distances.block(row_begin, first, some, rows.rows()) =
                                            distances_of_tiles(held.middleRows(row_begin, some),
                                                               begin + row_begin, rows, first);
                                    });
                   });
        passes.gather(numbers_of(distances));
        visit(begin, distances);
    }
    return passes.space();
}

ClassicalScaling classical_scaling(const MeshStream& meshes, int dimensions,
                                   const StreamedDistancesOptions& options)
{
    check(options);
    if (meshes.size() < 2)
        throw InvalidInput(join("distances need at least 2 meshes, there are ", meshes.size()));
    require(dimensions >= 1 && dimensions <= meshes.size(), "dimensions", dimensions,
            join("in [1, ", meshes.size(), "]"));
    const auto modes = std::min<Index>(dimensions, meshes.size() - 1);
    const StreamedFit fit =
        fit_model(meshes, {.modes = static_cast<int>(modes), .space = options.space},
                  {.memory = options.memory, .progress = options.progress, .ranks = options.ranks});
    const ShapeModel& model = fit.model;
    const double degrees = static_cast<double>(meshes.size() - 1);
    Eigen::MatrixXd points = Eigen::MatrixXd::Zero(meshes.size(), dimensions);
    ClassicalScaling result{{}, Eigen::VectorXd::Zero(dimensions), degrees * model.total_variance};
    for (Index k = 0; k < model.variances.size(); ++k) {
        points.col(k) = model.scores.col(k);
        fix_sign(points.col(k));
        result.eigenvalues[k] = degrees * model.variances[k];
    }
    result.points = points;
    return result;
}

} // namespace shape
