// SPDX-License-Identifier: MIT

#include "libshape/statistics/linear_model_plan.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <numeric>
#include <utility>

#include "libshape/base/counted.h"
#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/random.h"
#include "libshape/base/stop.h"
#include "libshape/base/to_size.h"
#include "libshape/statistics/design_symmetries.h"

namespace shape::internal {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Blocks = std::vector<std::vector<int>>;

constexpr double rank_tolerance =
    1e-9; ///< Columns, of length at most 1, that leave less are multiples of others.
constexpr double tie_tolerance =
    1e-9; ///< Shares in [0, 1] that differ by less are equal but for rounding.

void check_data(Index count, const MatrixXd& tested, const MatrixXd& nuisance,
                const Grouping& blocks)
{
    if (tested.rows() != count || nuisance.rows() != count || blocks.size() != count ||
        tested.cols() == 0)
        throw InvalidInput(join("linear model: observations are ", count, ", tested columns ",
                                tested.rows(), " by ", tested.cols(), ", nuisance columns ",
                                nuisance.rows(), " by ", nuisance.cols(), ", blocks ",
                                blocks.size(),
                                "; all must have as many rows and something must be tested"));
    if (!tested.allFinite() || !nuisance.allFinite())
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

/// Tested columns and nuisance side by side, whose rows are few different ones where the observations are
/// groups: then a permutation is a byte for each of them.
struct DistinctRows
{
    RowMatrix rows;
    std::vector<int> number_of; ///< Of each observation.

    explicit DistinctRows(const RowMatrix& all) : number_of(to_size(all.rows()))
    {
        std::map<std::vector<double>, int> known;
        std::vector<Index> firsts;
        for (Index i = 0; i < all.rows(); ++i) {
            const std::vector<double> row(all.row(i).begin(), all.row(i).end());
            const auto [place, is_new] = known.emplace(row, static_cast<int>(known.size()));
            number_of[to_size(i)] = place->second;
            if (is_new)
                firsts.push_back(i);
        }
        rows = all(firsts, Eigen::all);
    }

    [[nodiscard]] bool are_few() const { return rows.rows() <= 256; }
};

/// See LinearModelTest.
/// @param columns  Tested and nuisance about their means in each block, 0 where they are constant there.
/// @param tested, nuisance  Orthonormal bases of them.
double smallest_p(const RowMatrix& columns, const MatrixXd& tested, const MatrixXd& nuisance,
                  const Blocks& blocks)
{
    std::vector<int> cells; // the first row of each
    std::vector<int> kinds;
    std::map<std::pair<std::size_t, std::size_t>, int> known_kinds; // block, and how often
    double different = 0.0; // the logarithm of the multinomial coefficients
    for (std::size_t b = 0; b < blocks.size(); ++b) {
        std::map<std::vector<double>, std::pair<std::size_t, int>> counts; // and the first
        double placed = 0.0;
        for (const int i : blocks[b]) {
            const std::vector<double> row(columns.row(i).begin(), columns.row(i).end());
            auto& [count, first] = counts.try_emplace(row, 0, i).first->second;
            different += std::log(++placed) - std::log(static_cast<double>(++count));
        }
        for (const auto& [row, cell] : counts) {
            cells.push_back(cell.second);
            kinds.push_back(
                known_kinds.try_emplace({b, cell.first}, static_cast<int>(known_kinds.size()))
                    .first->second);
        }
    }
    const RowMatrix rows = tested(cells, Eigen::all);
    return std::exp(design_symmetries(rows, nuisance(cells, Eigen::all), kinds) - different);
}

/// For some members, the row of each observation after the permutation.
struct PermutedRows
{
    std::vector<std::uint8_t> few;
    std::vector<std::int32_t> many;
    std::vector<RowMatrix>
        taken; ///< For each member, the shares of the nuisance in the permuted columns.

    [[nodiscard]] int at(std::size_t place) const
    {
        return many.empty() ? few[place] : many[place];
    }
};

} // namespace

struct LinearModelPlan::Model
{
    Observations observations;
    Blocks blocks;
    MatrixXd tested;   ///< Orthonormal basis of R tested.
    MatrixXd nuisance; ///< Orthonormal basis of the nuisance beyond the blocks.
    PermutationOptions options;

    /// Sums of the observations of each part.
    [[nodiscard]] PartSums parts(const std::vector<int>& part_of_row, Index count) const
    {
        PartSums result{observations.points, observations.row_of, observations.shares, count};
        for (int& part : result.part_of)
            part = part_of_row[to_size(part)];
        return result;
    }

    [[nodiscard]] std::vector<std::uint64_t> seeds() const
    {
        throw_if_stop_requested(); // there may be many
        Random random(options.seed);
        std::vector<std::uint64_t> result(to_size(options.permutations));
        for (std::uint64_t& seed : result)
            seed = random.bits();
        return result;
    }
};

DesignColumns design_columns(const MatrixXd& tested, const MatrixXd& nuisance, const Blocks& blocks)
{
    DesignColumns result;
    result.all.resize(tested.rows(), tested.cols() + nuisance.cols());
    result.all << centred_and_scaled(tested, blocks), centred_and_scaled(nuisance, blocks);
    result.nuisance = orthonormal_basis(result.all.rightCols(nuisance.cols()));
    result.tested = orthonormal_basis(without(result.nuisance, result.all.leftCols(tested.cols())));
    return result;
}

Observations all_points(Index count)
{
    std::vector<int> points(to_size(count));
    std::iota(points.begin(), points.end(), 0);
    return {points, points, Eigen::VectorXd::Ones(count), count};
}

LinearModelPlan::LinearModelPlan(Observations observations, const MatrixXd& tested,
                                 const MatrixXd& nuisance, const Grouping& blocks,
                                 const PermutationOptions& options)
{
    check(options);
    const Index count = observations.count;
    check_data(count, tested, nuisance, blocks);
    const Blocks lists = members(blocks);
    const auto [columns, left, taken] = design_columns(tested, nuisance, lists);
    degrees_.permutations = options.permutations;
    degrees_.degrees_of_freedom = static_cast<int>(left.cols());
    degrees_.residual_degrees_of_freedom =
        static_cast<int>(count - blocks.group_count() - taken.cols()) - degrees_.degrees_of_freedom;
    if (degrees_.degrees_of_freedom == 0)
        throw InvalidInput(
            "linear model: what is tested does not vary beyond the blocks and the other columns; "
            "leave out the covariate that goes with it");
    if (degrees_.residual_degrees_of_freedom < 1)
        throw InvalidInput(
            join("linear model: ", counted(count, "observation is", "observations are"),
                 " too few: the ", blocks.group_count() > 1 ? "means of the blocks" : "mean",
                 " take", blocks.group_count() > 1 ? " " : "s ", blocks.group_count(),
                 taken.cols() > 0 ? join(", the other columns ", taken.cols()) : std::string(),
                 " and what is tested ", degrees_.degrees_of_freedom,
                 " of them, and nothing is left to measure chance by"));
    degrees_.smallest_p = smallest_p(columns, left, taken, lists);
    model_ =
        std::make_shared<const Model>(Model{std::move(observations), lists, left, taken, options});
}

/// R P [tested, nuisance]: member 0 takes the observations as they are, the others permute them. R takes
/// from permuted columns, which are about their means in each block already, the nuisance.
SumFamily LinearModelPlan::family() const
{
    const Index count = model_->observations.count;
    const Index width = model_->tested.cols() + model_->nuisance.cols();
    RowMatrix both(count, width);
    both << model_->tested, model_->nuisance;
    const auto distinct = std::make_shared<const DistinctRows>(both);

    SumFamily family;
    family.members = model_->options.permutations + 1;
    family.columns = {{width, model_->observations.points}};
    family.bytes_per_member = to_size(count) * (distinct->are_few() ? 1 : 4);
    family.prepare = [model = model_, distinct, seeds = model_->seeds(), count, width](
                         Index begin, Index end) -> SumFamily::Fill {
        const MatrixXd& nuisance = model->nuisance;
        const auto permuted = std::make_shared<PermutedRows>();
        const auto size = to_size(count * (end - begin));
        if (distinct->are_few())
            permuted->few.resize(size);
        else
            permuted->many.resize(size);
        for (Index member = begin; member < end; ++member) {
            const std::vector<int> permutation =
                member == 0 ? all_points(count).row_of
                            : permutation_within(model->blocks, count, seeds[to_size(member - 1)]);
            RowMatrix taken = RowMatrix::Zero(nuisance.cols(), width);
            for (Index i = 0; i < count; ++i) {
                const int number = distinct->number_of[to_size(permutation[to_size(i)])];
                const std::size_t place = to_size((member - begin) * count + i);
                if (distinct->are_few())
                    permuted->few[place] = static_cast<std::uint8_t>(number);
                else
                    permuted->many[place] = number;
                if (nuisance.cols() > 0 && member > 0)
                    taken += nuisance.row(i).transpose() * distinct->rows.row(number);
            }
            permuted->taken.push_back(std::move(taken));
        }
        return [model, distinct, permuted, begin, count](Index member, std::size_t,
                                                         std::size_t from, Block weights) {
            const std::size_t first = to_size((member - begin) * count);
            for (Index i = 0; i < weights.rows(); ++i) {
                const std::size_t point = from + to_size(i);
                const int row = model->observations.row_of[point];
                auto to = weights.row(i);
                to = distinct->rows.row(permuted->at(first + to_size(row)));
                if (model->nuisance.cols() > 0)
                    to -= model->nuisance.row(row) * permuted->taken[to_size(member - begin)];
                to *= model->observations.shares[static_cast<Index>(point)];
            }
        };
    };
    return family;
}

void LinearModelPlan::ask(SumQuestions& questions)
{
    family_ = questions.families.size();
    questions.families.push_back(family());
    first_part_ = questions.parts.size();
    const Index count = model_->observations.count;
    std::vector<int> block_of(to_size(count));
    for (std::size_t b = 0; b < model_->blocks.size(); ++b)
        for (const int row : model_->blocks[b])
            block_of[to_size(row)] = static_cast<int>(b);
    questions.parts.push_back(model_->parts(all_points(count).row_of, count)); // the observations
    questions.parts.push_back(model_->parts(block_of, static_cast<Index>(model_->blocks.size())));
    questions.parts.push_back(model_->parts(std::vector<int>(to_size(count), 0), 1));
}

LinearModelTest LinearModelPlan::conclude(const SumAnswers& answers) const
{
    const Eigen::VectorXd& rows = answers.parts[first_part_];
    const Eigen::VectorXd& blocks = answers.parts[first_part_ + 1];
    const double sum = answers.parts[first_part_ + 2][0];
    const std::vector<MatrixXd>& members = answers.families[family_];
    const Index rank = model_->tested.cols();
    const auto explained = [&](const MatrixXd& products) {
        return products.diagonal().head(rank).sum();
    };
    const auto taken = [&](const MatrixXd& products) {
        return products.diagonal().tail(products.rows() - rank).sum();
    };
    double within = rows.sum(); // about the means of the blocks
    for (std::size_t b = 0; b < model_->blocks.size(); ++b)
        within -= blocks[static_cast<Index>(b)] / static_cast<double>(model_->blocks[b].size());
    const double left = within - taken(members[0]);
    // Its rounding is that of the squares, which may be far larger.
    if (!(left > 1e-14 * static_cast<double>(rows.size()) * rows.maxCoeff()))
        throw InvalidInput("linear model: the observations do not vary within the blocks");

    LinearModelTest result = degrees_;
    result.total_sum_of_squares = rows.sum() - sum / static_cast<double>(rows.size());
    result.sum_of_squares = explained(members[0]);
    result.residual_sum_of_squares = left - result.sum_of_squares;
    result.r_squared = result.sum_of_squares / result.total_sum_of_squares;
    const double mean_square = result.sum_of_squares / result.degrees_of_freedom;
    // `left` less what is explained: what rounding leaves of two equal sums.
    const bool is_perfect = result.residual_sum_of_squares <= 1e-14 * left;
    result.f =
        is_perfect
            ? std::numeric_limits<double>::infinity()
            : mean_square / (result.residual_sum_of_squares / result.residual_degrees_of_freedom);
    // R is permuted too: what the nuisance takes from permuted residuals is not theirs.
    const double share = result.sum_of_squares / left;
    const auto extreme = std::count_if(members.begin() + 1, members.end(), [&](const MatrixXd& m) {
        return explained(m) / (left - taken(m)) >= share - tie_tolerance;
    });
    if (model_->options.permutations > 0)
        result.p_value =
            std::max((1.0 + static_cast<double>(extreme)) / (1.0 + model_->options.permutations),
                     result.smallest_p); // chance may draw fewer of the largest than there are
    return result;
}

} // namespace shape::internal
