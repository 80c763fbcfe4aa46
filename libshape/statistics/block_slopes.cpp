// SPDX-License-Identifier: MIT

#include "libshape/statistics/block_slopes.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/random.h"
#include "libshape/base/stop.h"
#include "libshape/base/threads.h"
#include "libshape/base/to_size.h"
#include "libshape/statistics/linear_model_plan.h"

namespace shape::internal {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Of columns of length at most 1: what is less is rounding. That of test_linear_model().
constexpr double rounding = 1e-9;

struct Inverse
{
    MatrixXd matrix;
    Index rank = 0;
};

/// The pseudo-inverse of products of columns.
Inverse inverse_of(const MatrixXd& symmetric, double largest)
{
    const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(symmetric);
    Inverse result{MatrixXd::Zero(symmetric.rows(), symmetric.cols()), 0};
    for (Index k = 0; k < symmetric.rows(); ++k) {
        const double value = solver.eigenvalues()[k];
        if (value <= rounding * largest)
            continue;
        const VectorXd vector = solver.eigenvectors().col(k);
        result.matrix += vector * vector.transpose() / value;
        ++result.rank;
    }
    return result;
}

/// What blocks add to the slopes: K sums of observations each.
struct Contributions
{
    Index blocks = 0;
    Index width = 0;      ///< K.
    MatrixXd products;    ///< B K by B K: of the sums.
    MatrixXd own_squares; ///< K by B K: inner products of the weights of each.
    MatrixXd
        taken; ///< By B K: what the nuisance has in common with the tested columns in each block.

    [[nodiscard]] auto of(const MatrixXd& columns, Index block) const
    {
        return columns.middleCols(block * width, width);
    }
};

/// What each block adds is Q_b^T (x - N N^T x) for bases Q of the tested columns and N of the nuisance.
Contributions contributions_of(const MatrixXd& products, const DesignColumns& columns,
                               const std::vector<std::vector<int>>& blocks)
{
    std::vector<std::vector<int>> varying;
    for (const std::vector<int>& block : blocks)
        if (columns.tested(block, Eigen::all).norm() > rounding)
            varying.push_back(block);
    Contributions result;
    result.blocks = std::ssize(varying);
    result.width = columns.tested.cols();
    const Index width = result.width;
    const Index count = result.blocks * width;
    MatrixXd moved(products.rows(), count); // the products with Q_b
    result.own_squares.resize(width, count);
    result.taken.resize(columns.nuisance.cols(), count);
    for (Index b = 0; b < result.blocks; ++b) {
        const std::vector<int>& rows = varying[to_size(b)];
        const MatrixXd own = columns.tested(rows, Eigen::all);
        moved.middleCols(b * width, width) = products(Eigen::all, rows) * own;
        const MatrixXd taken = columns.nuisance(rows, Eigen::all).transpose() * own;
        result.taken.middleCols(b * width, width) = taken;
        result.own_squares.middleCols(b * width, width) =
            own.transpose() * own - taken.transpose() * taken;
    }
    result.products.resize(count, count);
    for (Index b = 0; b < result.blocks; ++b) {
        const std::vector<int>& rows = varying[to_size(b)];
        result.products.middleRows(b * width, width) =
            columns.tested(rows, Eigen::all).transpose() * moved(rows, Eigen::all);
    }
    if (columns.nuisance.cols() > 0) {
        const MatrixXd crossed = (columns.nuisance.transpose() * moved).transpose() * result.taken;
        const MatrixXd inner = columns.nuisance.transpose() * products * columns.nuisance;
        result.products +=
            result.taken.transpose() * inner * result.taken - crossed - crossed.transpose().eval();
    }
    return result;
}

/// What the tested columns explain when blocks have some signs, of each of some such.
/// @param signs  B by M.
VectorXd explained(const Contributions& parts, const MatrixXd& signs)
{
    const Index width = parts.width;
    MatrixXd columns = MatrixXd::Zero(parts.blocks * width, signs.cols() * width);
    for (Index m = 0; m < signs.cols(); ++m)
        for (Index b = 0; b < parts.blocks; ++b)
            columns.block(b * width, m * width, width, width).diagonal().setConstant(signs(b, m));
    const MatrixXd summed = parts.products * columns;
    VectorXd result(signs.cols());
    for (Index m = 0; m < signs.cols(); ++m) {
        const auto own = columns.middleCols(m * width, width);
        const MatrixXd squares = own.transpose() * summed.middleCols(m * width, width);
        if (parts.taken.rows() == 0) {
            result[m] = squares.trace();
            continue;
        }
        // The nuisance takes its part from columns whose signs are others.
        const MatrixXd taken = parts.taken * own;
        const MatrixXd left = MatrixXd::Identity(width, width) - taken.transpose() * taken;
        result[m] = inverse_of(left, 1.0).matrix.cwiseProduct(squares).sum();
    }
    return result;
}

MatrixXd random_signs(Index blocks, const std::vector<std::uint64_t>& seeds)
{
    MatrixXd signs(blocks, std::ssize(seeds));
    for (Index m = 0; m < signs.cols(); ++m) {
        Random random(seeds[to_size(m)]);
        for (Index b = 0; b < blocks; ++b)
            signs(b, m) = random.index(2) == 0 ? 1.0 : -1.0;
    }
    return signs;
}

/// How many of the drawn signs explain as much.
int count_extreme(const Contributions& parts, double least, const PermutationOptions& options)
{
    constexpr std::size_t together = 16; // products of that many columns cost less each
    const auto count = to_size(options.permutations);
    throw_if_stop_requested(); // there may be many
    Random random(options.seed);
    std::vector<std::uint64_t> seeds(count);
    for (std::uint64_t& seed : seeds)
        seed = random.bits();
    std::vector<int> extreme((count + together - 1) / together, 0);
    parallel_for(count, together, [&](std::size_t begin, std::size_t end) {
        const std::vector<std::uint64_t> own(seeds.begin() + static_cast<std::ptrdiff_t>(begin),
                                             seeds.begin() + static_cast<std::ptrdiff_t>(end));
        const VectorXd found = explained(parts, random_signs(parts.blocks, own));
        extreme[begin / together] = static_cast<int>((found.array() >= least).count());
    });
    int sum = 0;
    for (const int found : extreme)
        sum += found;
    return sum;
}

} // namespace

LinearModelTest test_slopes(const MatrixXd& products, const MatrixXd& tested,
                            const MatrixXd& nuisance, const Grouping& blocks,
                            const PermutationOptions& options)
{
    LinearModelTest result =
        test_linear_model(products, tested, nuisance, blocks, {.permutations = 0});
    const std::vector<std::vector<int>> lists = members(blocks);
    const DesignColumns columns = design_columns(tested, nuisance, lists);
    const Contributions parts = contributions_of(products, columns, lists);
    double slopes = 0.0; // what one slope for each block explains
    Index rank = 0;
    for (Index b = 0; b < parts.blocks; ++b) {
        const MatrixXd squares = parts.of(parts.own_squares, b);
        const Inverse inverse = inverse_of(squares, squares.trace());
        const auto own =
            parts.products.block(b * parts.width, b * parts.width, parts.width, parts.width);
        slopes += inverse.matrix.cwiseProduct(own).sum();
        rank += inverse.rank;
    }
    result.residual_degrees_of_freedom = static_cast<int>(rank - parts.width);
    if (parts.blocks < 2 || result.residual_degrees_of_freedom < 1)
        throw InvalidInput(join("slopes: what is tested varies in ", parts.blocks, " of ",
                                blocks.group_count(),
                                " blocks, too few to tell how much slopes differ between blocks"));
    result.permutations = options.permutations;
    result.residual_sum_of_squares = std::max(slopes - result.sum_of_squares, 0.0);
    const bool is_perfect = result.residual_sum_of_squares <= 1e-14 * slopes;
    result.f = is_perfect
                   ? std::numeric_limits<double>::infinity()
                   : result.sum_of_squares / result.degrees_of_freedom /
                         (result.residual_sum_of_squares / result.residual_degrees_of_freedom);
    result.smallest_p = std::exp2(static_cast<double>(1 - parts.blocks));
    if (options.permutations > 0) {
        const double least = result.sum_of_squares - rounding * slopes; // equal but for rounding
        result.p_value =
            std::max((1.0 + count_extreme(parts, least, options)) / (1.0 + options.permutations),
                     result.smallest_p);
    }
    return result;
}

} // namespace shape::internal
