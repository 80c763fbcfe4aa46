// SPDX-License-Identifier: MIT

#include "libshape/statistics/linear_model.h"

#include <Eigen/QR>
#include <limits>
#include <utility>
#include <vector>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/random.h"
#include "libshape/base/require.h"
#include "libshape/base/threads.h"
#include "libshape/base/to_size.h"

namespace shape {
using namespace internal;
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Blocks = std::vector<std::vector<int>>;

constexpr double rank_tolerance =
    1e-9; ///< Columns, of length at most 1, that leave less are multiples of others.
constexpr double tie_tolerance =
    1e-9; ///< Shares in [0, 1] that differ by less are equal but for rounding.

void check_data(const MatrixXd& products, const MatrixXd& tested, const MatrixXd& nuisance,
                const Grouping& blocks)
{
    const Index count = products.rows();
    if (products.cols() != count || tested.rows() != count || nuisance.rows() != count ||
        blocks.size() != count || tested.cols() == 0)
        throw InvalidInput(join("linear model: inner products are ", count, " by ", products.cols(),
                                ", tested columns ", tested.rows(), " by ", tested.cols(),
                                ", nuisance columns ", nuisance.rows(), " by ", nuisance.cols(),
                                ", blocks ", blocks.size(),
                                "; all must have as many rows and something must be tested"));
    if (!products.allFinite() || !tested.allFinite() || !nuisance.allFinite())
        throw InvalidInput("linear model: an entry is not finite");
}

/// Columns about their means in each block.
MatrixXd centred(MatrixXd columns, const Blocks& blocks)
{
    for (const std::vector<int>& block : blocks) {
        const Eigen::RowVectorXd mean = columns(block, Eigen::all).colwise().mean();
        columns(block, Eigen::all).rowwise() -= mean;
    }
    return columns;
}

/// Columns about their means in each block, of length 1; 0 if that is all there was to them, but for
/// the rounding of N sums (1e-12).
MatrixXd centred_and_scaled(const MatrixXd& columns, const Blocks& blocks)
{
    MatrixXd result = centred(columns, blocks);
    for (Index c = 0; c < result.cols(); ++c) {
        const double length = result.col(c).norm();
        result.col(c) *= length > 1e-12 * columns.col(c).norm() ? 1.0 / length : 0.0;
    }
    return result;
}

/// Orthonormal columns with the same span.
MatrixXd orthonormal_basis(const MatrixXd& columns)
{
    if (columns.cols() == 0)
        return columns;
    const Eigen::ColPivHouseholderQR<MatrixXd> qr(columns);
    Index rank = 0;
    while (rank < std::min(columns.rows(), columns.cols()) &&
           std::abs(qr.matrixQR()(rank, rank)) > rank_tolerance)
        ++rank;
    return qr.householderQ() * MatrixXd::Identity(columns.rows(), rank);
}

/// What the columns leave over: (I - Q Q^T) x, for orthonormal Q.
MatrixXd without(const MatrixXd& basis, const MatrixXd& x)
{
    return x - basis * (basis.transpose() * x);
}

/// A random permutation that takes every block into itself.
std::vector<int> permutation_within(const Blocks& blocks, Index count, std::uint64_t seed)
{
    Random random(seed);
    std::vector<int> permutation(to_size(count));
    for (const std::vector<int>& block : blocks) {
        std::vector<int> shuffled = block;
        for (std::size_t i = shuffled.size(); i > 1; --i)
            std::swap(shuffled[i - 1], shuffled[random.index(i)]);
        for (std::size_t i = 0; i < block.size(); ++i)
            permutation[to_size(block[i])] = shuffled[i];
    }
    return permutation;
}

/// The model without the tested columns, and bases for what is tested and what is not.
struct ReducedModel
{
    Blocks blocks;
    MatrixXd products; ///< R G R.
    MatrixXd tested;   ///< Orthonormal basis of R tested.
    MatrixXd nuisance; ///< Orthonormal basis of the nuisance beyond the blocks.
};

ReducedModel reduce(const MatrixXd& products, const MatrixXd& tested, const MatrixXd& nuisance,
                    const Grouping& blocks)
{
    ReducedModel model;
    model.blocks = members(blocks);
    model.nuisance = orthonormal_basis(centred_and_scaled(nuisance, model.blocks));
    model.tested =
        orthonormal_basis(without(model.nuisance, centred_and_scaled(tested, model.blocks)));
    const auto residuals = [&](const MatrixXd& x) {
        return without(model.nuisance, centred(x, model.blocks));
    };
    model.products = residuals(residuals(products).transpose());
    return model;
}

/// Share of the variation that the tested columns explain, of what the others leave over, for each
/// of some permutations of the residuals; all in one product of matrices, which is quicker.
Eigen::VectorXd explained_shares(const ReducedModel& model,
                                 const std::vector<std::vector<int>>& permutations)
{
    const Index rank = model.tested.cols();
    const Index width = rank + model.nuisance.cols();
    const auto count = static_cast<Index>(permutations.size());
    MatrixXd columns(model.products.rows(), width * count);
    for (Index k = 0; k < count; ++k) {
        const std::vector<int>& permutation = permutations[to_size(k)];
        columns.middleCols(k * width, rank) = model.tested(permutation, Eigen::all);
        columns.middleCols(k * width + rank, width - rank) =
            model.nuisance(permutation, Eigen::all);
    }
    const Eigen::VectorXd squares =
        columns.cwiseProduct(model.products * columns).colwise().sum().transpose();
    const double all = model.products.trace();
    Eigen::VectorXd shares(count);
    for (Index k = 0; k < count; ++k)
        shares[k] = squares.segment(k * width, rank).sum() /
                    (all - squares.segment(k * width + rank, width - rank).sum());
    return shares;
}

/// How many of the permutations explain at least the share.
int count_at_least(const ReducedModel& model, double share, const PermutationOptions& options)
{
    Random random(options.seed);
    std::vector<std::uint64_t> seeds(to_size(options.permutations));
    for (std::uint64_t& seed : seeds)
        seed = random.bits();
    const double sum = parallel_sum(seeds.size(), 16, [&](std::size_t begin, std::size_t end) {
        std::vector<std::vector<int>> permutations;
        for (std::size_t k = begin; k < end; ++k)
            permutations.push_back(
                permutation_within(model.blocks, model.products.rows(), seeds[k]));
        const Eigen::VectorXd shares = explained_shares(model, permutations);
        return static_cast<double>((shares.array() >= share - tie_tolerance).count());
    });
    return static_cast<int>(sum);
}

} // namespace

void check(const PermutationOptions& options)
{
    require_at_least(0, options.permutations, "PermutationOptions.permutations");
}

LinearModelTest test_linear_model(const MatrixXd& products, const MatrixXd& tested,
                                  const MatrixXd& nuisance, const Grouping& blocks,
                                  const PermutationOptions& options)
{
    check(options);
    check_data(products, tested, nuisance, blocks);
    const ReducedModel model = reduce(products, tested, nuisance, blocks);
    const Index count = products.rows();
    LinearModelTest result;
    result.degrees_of_freedom = static_cast<int>(model.tested.cols());
    result.residual_degrees_of_freedom =
        static_cast<int>(count - blocks.group_count() - model.nuisance.cols()) -
        result.degrees_of_freedom;
    if (result.degrees_of_freedom == 0)
        throw InvalidInput(
            "linear model: what is tested does not vary beyond the blocks and the other columns");
    if (result.residual_degrees_of_freedom < 1)
        throw InvalidInput(join("linear model: ", count, " observations in ", blocks.group_count(),
                                " blocks with ", model.nuisance.cols(), " nuisance columns and ",
                                result.degrees_of_freedom,
                                " tested ones leave no degree of freedom"));
    const double left =
        model.products.trace(); // its rounding is that of `products`, which may be far larger
    if (!(left > 1e-14 * static_cast<double>(count) * products.cwiseAbs().maxCoeff()))
        throw InvalidInput("linear model: the observations do not vary within the blocks");

    result.permutations = options.permutations;
    result.total_sum_of_squares = products.trace() - products.sum() / static_cast<double>(count);
    result.sum_of_squares = model.tested.cwiseProduct(model.products * model.tested).sum();
    result.residual_sum_of_squares = left - result.sum_of_squares;
    result.r_squared = result.sum_of_squares / result.total_sum_of_squares;
    const double mean_square = result.sum_of_squares / result.degrees_of_freedom;
    const bool is_perfect = result.residual_sum_of_squares <= 1e-14 * left;
    result.f =
        is_perfect
            ? std::numeric_limits<double>::infinity()
            : mean_square / (result.residual_sum_of_squares / result.residual_degrees_of_freedom);
    const int extreme = count_at_least(model, result.sum_of_squares / left, options);
    result.p_value = (1.0 + extreme) / (1.0 + options.permutations);
    return result;
}

} // namespace shape
