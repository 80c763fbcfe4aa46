// SPDX-License-Identifier: MIT

#include "libshape/statistics/group_fit.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <set>
#include <utility>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/to_size.h"

namespace shape::internal {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::RowVectorXd;
using Eigen::VectorXd;

/// Points that belong to rows, ascending.
std::vector<int> points_that_count(const Grouping& groups, const Grouping& blocks,
                                   BlockDesign design)
{
    std::vector<std::set<int>> groups_of_block(blocks.names.size());
    for (std::size_t i = 0; i < groups.group_of.size(); ++i)
        groups_of_block[to_size(blocks.group_of[i])].insert(groups.group_of[i]);
    const auto is_of_several = [&](std::size_t i) {
        return groups_of_block[to_size(blocks.group_of[i])].size() > 1;
    };
    std::vector<bool> is_compared(groups.names.size(), false); // within a block
    for (std::size_t i = 0; i < groups.group_of.size(); ++i)
        if (is_of_several(i))
            is_compared[to_size(groups.group_of[i])] = true;
    std::vector<int> points;
    for (std::size_t i = 0; i < groups.group_of.size(); ++i)
        if (design == BlockDesign::Nested || is_of_several(i) ||
            !is_compared[to_size(groups.group_of[i])])
            points.push_back(static_cast<int>(i));
    return points;
}

/// Without the groups that are empty; the others keep their order.
Grouping without_empty(const Grouping& grouping)
{
    std::vector<int> number(grouping.names.size(), -1);
    for (const int group : grouping.group_of)
        number[to_size(group)] = 0;
    Grouping result;
    for (std::size_t g = 0; g < number.size(); ++g)
        if (number[g] == 0) {
            number[g] = result.group_count();
            result.names.push_back(grouping.names[g]);
        }
    for (const int group : grouping.group_of)
        result.group_of.push_back(number[to_size(group)]);
    return result;
}

/// Of numbers of about 1: what is left open beyond this is more than rounding.
constexpr double open_tolerance = 1e-6;

struct PseudoInverse
{
    MatrixXd matrix;
    MatrixXd null_space;
};

/// Of normal equations in columns that vary by about 1 over so many rows. A column that varies by less than a
/// millionth of that beyond the others is rounding.
PseudoInverse pseudo_inverse(const MatrixXd& normal, double rows)
{
    const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(normal);
    const VectorXd& values = solver.eigenvalues(); // ascending
    const Index open = (values.array() <= 1e-12 * rows).count();
    const Index rank = values.size() - open;
    const MatrixXd vectors = solver.eigenvectors().rightCols(rank);
    return {vectors * values.tail(rank).cwiseInverse().asDiagonal() * vectors.transpose(),
            solver.eigenvectors().leftCols(open)};
}

} // namespace

GroupRows rows_of_groups(const Grouping& groups, const Grouping& blocks, const MatrixXd& covariates)
{
    if (blocks.size() != groups.size() || covariates.rows() != groups.size())
        throw InvalidInput(join("groups are of ", groups.size(), " observations, blocks of ",
                                blocks.size(), ", covariates of ", covariates.rows(),
                                "; all must agree"));
    (void)members(groups); // none is empty
    GroupRows rows;
    rows.design = block_design(groups, blocks);
    rows.groups.names = groups.names;
    rows.blocks.names = blocks.names;
    Observations& observations = rows.observations;
    observations.points = points_that_count(groups, blocks, rows.design);
    std::map<std::pair<int, int>, int> numbers;
    std::vector<double> sizes;
    for (const int point : observations.points) {
        const int block = blocks.group_of[to_size(point)];
        const int group = groups.group_of[to_size(point)];
        const auto [place, is_new] =
            numbers.try_emplace({block, group}, static_cast<int>(sizes.size()));
        if (is_new) {
            sizes.push_back(0.0);
            rows.groups.group_of.push_back(group);
            rows.blocks.group_of.push_back(block);
        }
        sizes[to_size(place->second)] += 1.0;
        observations.row_of.push_back(place->second);
    }
    rows.blocks = without_empty(rows.blocks);
    observations.count = static_cast<Index>(sizes.size());
    observations.shares.resize(static_cast<Index>(observations.points.size()));
    rows.covariates = MatrixXd::Zero(observations.count, covariates.cols());
    for (std::size_t i = 0; i < observations.points.size(); ++i) {
        const int row = observations.row_of[i];
        const double share = 1.0 / sizes[to_size(row)];
        observations.shares[static_cast<Index>(i)] = share;
        rows.covariates.row(row) += share * covariates.row(observations.points[i]);
    }
    return rows;
}

GroupFit::GroupFit(const Grouping& groups, const Grouping& blocks, const MatrixXd& covariates)
    : rows_(rows_of_groups(groups, blocks, covariates)),
      points_(groups.size()),
      members_(shape::members(rows_.groups)),
      places_(members_.size())
{
    if (!covariates.allFinite())
        throw InvalidInput("groups: a covariate is not finite");
    const Observations& observations = rows_.observations;
    for (std::size_t i = 0; i < observations.points.size(); ++i)
        places_[to_size(group_of(observations.row_of[i]))].push_back(static_cast<int>(i));
    link_groups();
    set_columns();

    most_open_ = columns_.cols();
    all_ = solve(VectorXd::Ones(observations.count));
    most_open_ = all_.null_space.cols();
    const Index group_count = rows_.groups.group_count();
    row_weights_ = RowMatrix::Zero(observations.count, group_count);
    slopes_.resize(observations.count, covariates_.cols());
    for (Index row = 0; row < observations.count; ++row) {
        fill_means(all_, 1.0, row, row_weights_.row(row));
        if (is_adjusted())
            slopes_.row(row) = centred(all_, row) * all_.inverse.rightCols(covariates_.cols());
    }
    if (rows_.design == BlockDesign::Crossed && is_adjusted()) {
        // With few blocks, what groups take from the covariate of the one lies in all others.
        const MatrixXd within = block_centred_.rightCols(covariates_.cols());
        has_slope_of_one_block_ = std::max(slope_shares().maxCoeff(),
                                           shares_of_blocks(within).maxCoeff()) > determining_share;
    }
    open_ = MatrixXd::Zero(0, group_count);
    if (!is_direct_)
        open_ = all_.null_space.transpose() *
                (targets_ - all_.part_means(part_of_group_, Eigen::all).transpose());
}

/// Finds groups that chains of blocks link, and whether each of these blocks has all of them.
void GroupFit::link_groups()
{
    const std::size_t group_count = members_.size();
    part_of_group_.resize(group_count);
    std::iota(part_of_group_.begin(), part_of_group_.end(), 0);
    block_shares_ = VectorXd::Ones(rows_.observations.count);
    is_direct_ = rows_.covariates.cols() == 0;
    if (rows_.design == BlockDesign::Nested)
        return;
    const std::vector<std::vector<int>> blocks = shape::members(rows_.blocks);
    for (const std::vector<int>& block : blocks) {
        const int part = part_of(block.front());
        for (const int row : block) {
            block_shares_[row] = 1.0 / static_cast<double>(block.size());
            std::replace(part_of_group_.begin(), part_of_group_.end(), part_of(row), part);
        }
    }
    for (const std::vector<int>& block : blocks)
        if (std::cmp_not_equal(
                block.size(),
                std::count(part_of_group_.begin(), part_of_group_.end(), part_of(block.front()))))
            is_direct_ = false;
}

void GroupFit::set_columns()
{
    const Index count = rows_.observations.count;
    const Index group_count = rows_.groups.group_count();
    const Index covariate_count = rows_.covariates.cols();
    covariate_means_ =
        (block_shares_.transpose() * rows_.covariates).transpose() / block_shares_.sum();
    covariates_ = rows_.covariates.rowwise() - covariate_means_.transpose();
    for (Index c = 0; c < covariate_count; ++c) {
        const double length = covariates_.col(c).norm();
        const bool varies = length > 1e-12 * rows_.covariates.col(c).norm(); // more than rounding
        covariates_.col(c) *= varies ? std::sqrt(static_cast<double>(count)) / length : 0.0;
    }
    if (is_direct_)
        return;
    const bool is_crossed = rows_.design == BlockDesign::Crossed;
    const Index further = is_crossed ? group_count : 0;
    columns_.resize(count, further + covariate_count);
    columns_.rightCols(covariate_count) = covariates_;
    targets_ = MatrixXd::Zero(columns_.cols(), group_count);
    if (!is_crossed)
        return;
    columns_.leftCols(group_count) = indicators(rows_.groups);
    targets_.topRows(group_count).setIdentity();
    block_centred_ = columns_;
    for (const std::vector<int>& block : shape::members(rows_.blocks)) {
        const RowVectorXd mean = columns_(block, Eigen::all).colwise().mean();
        block_centred_(block, Eigen::all).rowwise() -= mean;
    }
}

int GroupFit::group_of(Index row) const
{
    return rows_.groups.group_of[to_size(row)];
}

int GroupFit::part_of(Index row) const
{
    return part_of_group_[to_size(group_of(row))];
}

bool GroupFit::is_plain() const
{
    return is_direct_ && rows_.observations.count == points_;
}

bool GroupFit::is_determined(int group) const
{
    return open_.col(group).norm() <= open_tolerance;
}

bool GroupFit::is_determined(int first, int second) const
{
    return (open_.col(first) - open_.col(second)).norm() <= open_tolerance;
}

/// The columns of a row about their mean in its block, or nested in its group.
RowVectorXd GroupFit::centred(const Solution& solution, Index row) const
{
    if (rows_.design == BlockDesign::Crossed)
        return block_centred_.row(row);
    return columns_.row(row) - solution.part_means.row(part_of(row));
}

GroupFit::Solution GroupFit::solve(const VectorXd& times) const
{
    const Index count = rows_.observations.count;
    const Index group_count = rows_.groups.group_count();
    Solution result;
    result.counts = VectorXd::Zero(group_count);
    for (Index row = 0; row < count; ++row)
        result.counts[group_of(row)] += times[row];
    result.is_determined = result.counts.minCoeff() > 0.0;
    if (is_direct_ || !result.is_determined)
        return result;
    result.covariates = MatrixXd::Zero(group_count, covariates_.cols());
    result.part_counts = VectorXd::Zero(group_count);
    result.part_means = MatrixXd::Zero(group_count, columns_.cols());
    for (Index row = 0; row < count; ++row) {
        const double counted = times[row] * block_shares_[row];
        result.covariates.row(group_of(row)) +=
            times[row] / result.counts[group_of(row)] * covariates_.row(row);
        result.part_counts[part_of(row)] += counted;
        result.part_means.row(part_of(row)) += counted * columns_.row(row);
    }
    for (Index part = 0; part < group_count; ++part)
        if (result.part_counts[part] > 0.0)
            result.part_means.row(part) /= result.part_counts[part];
    MatrixXd normal = MatrixXd::Zero(columns_.cols(), columns_.cols());
    for (Index row = 0; row < count; ++row) {
        if (times[row] == 0.0)
            continue;
        const RowVectorXd own = centred(result, row);
        normal.noalias() += times[row] * own.transpose() * own;
    }
    PseudoInverse inverse = pseudo_inverse(normal, times.sum());
    result.is_determined = inverse.null_space.cols() <= most_open_;
    result.inverse = std::move(inverse.matrix);
    result.null_space = std::move(inverse.null_space);
    result.coefficients =
        result.inverse * (targets_ - result.part_means(part_of_group_, Eigen::all).transpose());
    return result;
}

/// Weights of a row in the means.
void GroupFit::fill_means(const Solution& solution, double times, Index row,
                          Eigen::Ref<RowVectorXd> weights) const
{
    if (is_direct_) {
        weights.setZero();
        weights[group_of(row)] = times / solution.counts[group_of(row)];
        return;
    }
    const int part = part_of(row);
    weights = times * (centred(solution, row) * solution.coefficients);
    for (Index group = 0; group < weights.size(); ++group)
        if (part_of_group_[to_size(group)] == part)
            weights[group] += times * block_shares_[row] / solution.part_counts[part];
}

void GroupFit::fill_moves(const Solution& solution, double times, Index row,
                          Eigen::Ref<RowVectorXd> weights) const
{
    const Index group_count = rows_.groups.group_count();
    fill_means(solution, times, row, weights.head(group_count));
    weights.head(group_count) -= row_weights_.row(row);
    const int group = group_of(row);
    auto differences = weights.tail(group_count);
    // The rows of a group that were drawn have other covariates, for which the slopes account.
    differences = -slopes_.row(row) * (solution.covariates - all_.covariates).transpose();
    differences[group] += times / solution.counts[group] - 1.0 / all_.counts[group];
}

MatrixXd GroupFit::means() const
{
    const Observations& observations = rows_.observations;
    MatrixXd result = MatrixXd::Zero(points_, rows_.groups.group_count());
    for (std::size_t i = 0; i < observations.points.size(); ++i)
        result.row(observations.points[i]) =
            observations.shares[static_cast<Index>(i)] * row_weights_.row(observations.row_of[i]);
    for (Index group = 0; group < result.cols(); ++group)
        if (!is_determined(static_cast<int>(group)))
            result.col(group).setConstant(std::numeric_limits<double>::quiet_NaN());
    return result;
}

MatrixXd GroupFit::references() const
{
    const Observations& observations = rows_.observations;
    const Index group_count = rows_.groups.group_count();
    MatrixXd result = MatrixXd::Zero(points_, group_count + covariates_.cols());
    for (std::size_t i = 0; i < observations.points.size(); ++i) {
        const int row = observations.row_of[i];
        const double share = observations.shares[static_cast<Index>(i)];
        auto weights = result.row(observations.points[i]);
        weights[group_of(row)] = share / all_.counts[group_of(row)];
        weights.tail(covariates_.cols()) = share * slopes_.row(row);
    }
    return result;
}

MatrixXd GroupFit::expected() const
{
    const Index group_count = rows_.groups.group_count();
    MatrixXd result(rows_.observations.count, group_count + covariates_.cols());
    result.leftCols(group_count) = indicators(rows_.groups);
    for (Index row = 0; row < result.rows() && is_adjusted(); ++row)
        result.row(row).tail(covariates_.cols()) =
            covariates_.row(row) - all_.covariates.row(group_of(row));
    return result;
}

VectorXd GroupFit::leverages() const
{
    VectorXd result(rows_.observations.count);
    for (Index row = 0; row < result.size(); ++row) {
        result[row] = 1.0 / all_.counts[group_of(row)];
        if (is_adjusted() && rows_.design == BlockDesign::Nested) {
            const RowVectorXd own = centred(all_, row);
            result[row] += (own * all_.inverse).dot(own);
        }
    }
    return result;
}

MatrixXd GroupFit::slope_shares() const
{
    return shares_of_blocks(slopes_);
}

/// What part of the squares of each column, of one row each, a block has.
MatrixXd GroupFit::shares_of_blocks(const MatrixXd& columns) const
{
    MatrixXd shares = MatrixXd::Zero(rows_.blocks.group_count(), columns.cols());
    for (Index row = 0; row < columns.rows(); ++row)
        shares.row(rows_.blocks.group_of[to_size(row)]) += columns.row(row).cwiseAbs2();
    for (Index c = 0; c < shares.cols(); ++c)
        if (const double sum = shares.col(c).sum(); sum > 0.0)
            shares.col(c) /= sum;
    return shares;
}

std::vector<SumColumns> columns_of(const GroupFit& fit, Index width)
{
    const std::vector<int>& points = fit.rows().observations.points;
    if (!fit.is_direct())
        return {{width, points}};
    std::vector<SumColumns> columns;
    for (const std::vector<int>& places : fit.places()) {
        SumColumns of_group;
        for (const int place : places)
            of_group.support.push_back(points[to_size(place)]);
        columns.push_back(std::move(of_group));
    }
    return columns;
}

SumFamily means_of(const std::shared_ptr<const GroupFit>& fit)
{
    SumFamily family{1, columns_of(*fit, fit->rows().groups.group_count()), {}, 0};
    family.prepare = [fit](Index, Index) -> SumFamily::Fill {
        return [fit](Index, std::size_t set, std::size_t first, Block weights) {
            const Observations& all = fit->rows().observations;
            for (Index i = 0; i < weights.rows(); ++i) {
                const std::size_t number = first + to_size(i);
                const std::size_t place =
                    fit->is_direct() ? to_size(fit->places()[set][number]) : number;
                const auto of_row = fit->row_weights().row(all.row_of[place]);
                const double share = all.shares[static_cast<Index>(place)];
                if (fit->is_direct())
                    weights(i, 0) = share * of_row[static_cast<Index>(set)];
                else
                    weights.row(i) = share * of_row;
            }
        };
    };
    return family;
}

std::size_t ask_for_residuals(const GroupFit& fit, SumQuestions& questions)
{
    const std::size_t place = questions.parts.size();
    if (fit.is_plain()) {
        questions.groups = fit.rows().groups;
        return place;
    }
    const Observations& rows = fit.rows().observations;
    questions.references = fit.references();
    questions.parts.push_back({rows.points, rows.row_of, rows.shares, rows.count, fit.expected()});
    return place;
}

const VectorXd& squared_residuals(const GroupFit& fit, const SumAnswers& answers, std::size_t place)
{
    return fit.is_plain() ? answers.squares_about_means : answers.parts[place];
}

} // namespace shape::internal
