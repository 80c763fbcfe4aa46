// SPDX-License-Identifier: MIT

#include "libshape/statistics/block_krylov.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <bit>
#include <cmath>
#include <functional>
#include <limits>
#include <utility>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/random.h"
#include "libshape/base/require.h"
#include "libshape/base/to_size.h"
#include "libshape/linalg/block_products.h"
#include "libshape/linalg/strips.h"
#include "libshape/statistics/component_steps.h"

namespace shape::internal {
namespace {

using Eigen::Index;

constexpr Index strip = 2048; ///< Columns of the data that are worked on together.

/// The sum of what term(first, count, sum) adds for every strip, in the order of the strips.
RowMatrix sum_of_strips(Index total, Index rows, Index columns,
                        const std::function<void(Index, Index, RowMatrix&)>& term)
{
    std::vector<RowMatrix> sums(to_size((total + strip - 1) / strip));
    for_strips(total, strip, [&](Index first, Index count) {
        RowMatrix& sum = sums[to_size(first / strip)];
        sum = RowMatrix::Zero(rows, columns);
        term(first, count, sum);
    });
    RowMatrix sum = RowMatrix::Zero(rows, columns);
    for (const RowMatrix& part : sums)
        sum += part;
    return sum;
}

/// a^T b of tall matrices.
RowMatrix inner(const RowMatrix& a, const RowMatrix& b)
{
    return sum_of_strips(
        a.rows(), a.cols(), b.cols(), [&](Index first, Index count, RowMatrix& sum) {
            add_product_of_columns(a.middleRows(first, count), b.middleRows(first, count), sum);
        });
}

/// a -= b c of tall a and b.
void subtract_product(RowMatrix& a, const RowMatrix& b, const RowMatrix& c)
{
    const RowMatrix negative = -c;
    for_strips(a.rows(), strip, [&](Index first, Index count) {
        add_product(b.middleRows(first, count), negative, a.middleRows(first, count));
    });
}

/// a = a b in place.
void multiply_right(RowMatrix& a, const RowMatrix& b)
{
    RowMatrix result(a.rows(), b.cols());
    for_strips(a.rows(), strip, [&](Index first, Index count) {
        result.middleRows(first, count).setZero();
        add_product(a.middleRows(first, count), b, result.middleRows(first, count));
    });
    a = std::move(result);
}

/// Makes the columns orthonormal, leaving out what is rounding: a = q r. The norms that they are combined to ascend.
/// Inner products know squares to rounding of the largest alone, so combinations a millionth as long as that are set apart
/// and looked at among themselves.
/// @param floor  Columns combined to a norm below it are rounding.
/// @return r.
RowMatrix orthonormalise_columns(RowMatrix& a, double floor)
{
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(Eigen::MatrixXd(inner(a, a)));
    const Eigen::VectorXd& squares = solver.eigenvalues();
    const Eigen::MatrixXd& vectors = solver.eigenvectors();
    const double largest = squares.size() > 0 ? squares.maxCoeff() : 0.0;
    if (!(largest > floor * floor)) {
        a.resize(a.rows(), 0);
        return RowMatrix(0, vectors.rows());
    }
    Index kept = 0;
    while (kept < squares.size() && squares[squares.size() - 1 - kept] > 1e-12 * largest &&
           squares[squares.size() - 1 - kept] > floor * floor)
        ++kept;
    const Index small = squares.size() - kept;
    const Eigen::VectorXd norms = squares.tail(kept).cwiseSqrt();
    RowMatrix weights = vectors;
    weights.rightCols(kept) *= norms.cwiseInverse().asDiagonal();
    RowMatrix r = norms.asDiagonal() * vectors.rightCols(kept).transpose();
    const double rounding = std::numeric_limits<double>::epsilon() * std::sqrt(largest);
    multiply_right(a, weights);
    if (small == 0)
        return r;
    RowMatrix rest = a.leftCols(small);
    RowMatrix large = a.rightCols(kept);
    const RowMatrix shares = inner(large, rest);
    subtract_product(rest, large, shares);
    r += shares * vectors.leftCols(small).transpose();
    const RowMatrix r_of_rest = orthonormalise_columns(rest, std::max(floor, 100.0 * rounding));
    a.resize(a.rows(), rest.cols() + kept);
    a << rest, large;
    RowMatrix both(rest.cols() + kept, vectors.rows());
    both << r_of_rest * vectors.leftCols(small).transpose(), r;
    return both;
}

/// What rounding leaves of the least of these descending eigenvalues of C that is more than rounding itself, relative:
/// products with C are off by some units of the last place of the largest.
double rounding_of(const Eigen::VectorXd& values)
{
    double least = values[0];
    for (const double value : values)
        if (value > smallest_variance_ratio * values[0])
            least = value;
    return 4.0 * std::numeric_limits<double>::epsilon() * values[0] / least;
}

RowMatrix random_block(Index rows, Index columns, std::uint64_t seed)
{
    Random random(seed);
    RowMatrix block(rows, columns);
    for (double& value : block.reshaped<Eigen::RowMajor>())
        value = random.normal();
    return block;
}

} // namespace

void check(const BlockKrylovOptions& options)
{
    require(options.components >= 0, "BlockKrylovOptions.components", options.components, ">= 0");
    require(options.variance > 0.0 && options.variance <= 1.0, "BlockKrylovOptions.variance",
            options.variance, "in (0, 1]");
    require(options.tolerance > 0.0 && options.tolerance < 1.0, "BlockKrylovOptions.tolerance",
            options.tolerance, "in (0, 1)");
}

Index BlockKrylov::block_size(Index components)
{
    return components + std::max<Index>(10, components / 5);
}

Index BlockKrylov::tile_rows(Index columns)
{
    constexpr Index bytes = Index{32} << 20;
    const Index fit = bytes / (static_cast<Index>(sizeof(double)) * std::max<Index>(columns, 1));
    return std::clamp<Index>(static_cast<Index>(std::bit_floor(to_size(fit))), 4, 256);
}

BlockKrylov::BlockKrylov(Index rows, Index columns, const BlockKrylovOptions& options)
    : rows_(rows),
      columns_(columns),
      options_(options),
      size_(std::min({block_size(options.components > 0 ? options.components : 32), columns,
                      std::max<Index>(rows - 1, 1)})),
      sums_(Eigen::VectorXd::Zero(columns))
{
    check(options);
    const auto row = static_cast<double>(sizeof(double)) * static_cast<double>(columns_);
    const double block = row * static_cast<double>(size_);
    const auto memory = static_cast<double>(options.memory);
    constexpr double least_blocks = 5.0;
    // Every batch of rows goes through the basis and the product once. Measured once on docs/scale.md's planted meshes,
    // when both products were by BLAS: they took some 230 of 468 CPU s in batches of 32 rows, 170 of 327 of 128.
    constexpr double most_held = 128.0, least_held = 4.0;
    const double held = std::clamp(std::min(memory / 3.0, memory - least_blocks * block) / row,
                                   least_held, most_held);
    held_.resize(static_cast<Index>(held), columns_);
    const double left = held > least_held ? memory - held * row : memory;
    // Beside the basis stand the product and, while vectors are combined, another block.
    constexpr double most = 18.0; // more would cost more than they save
    most_blocks_ = static_cast<Index>(std::min(left / block, most)) - 2;
    if (most_blocks_ < 3)
        throw LimitExceeded(
            join("5 times ", size_, " vectors of ", columns_, " numbers and ", held_.rows(),
                 " rows need ",
                 static_cast<std::uint64_t>(least_blocks * block + held * row) / (1 << 20) + 1,
                 " MiB, beside the meshes ", options.memory >> 20,
                 " MiB are left; allow more memory or keep fewer modes"));
    basis_.push_back(random_block(columns_, size_, options.seed));
    orthonormalise_columns(basis_.front(), 0.0);
    product_ = RowMatrix::Zero(columns_, basis_.front().cols());
}

void BlockKrylov::start_from(RowMatrix sample)
{
    mean_ = sample.colwise().mean().transpose();
    const Index count = sample.rows();
    for_strips(columns_, strip, [&](Index first, Index width) {
        sample.middleCols(first, width).rowwise() -= mean_.segment(first, width).transpose();
    });
    const RowMatrix gram =
        sum_of_strips(columns_, count, count, [&](Index first, Index width, RowMatrix& sum) {
            add_product_with_rows(sample.middleCols(first, width), sample.middleCols(first, width),
                                  sum);
        });
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver{Eigen::MatrixXd(gram)};
    const Eigen::VectorXd squares = solver.eigenvalues().reverse();
    // A tenth of the vectors stays random: what is in no row of the sample is in them.
    const Index most = std::min(size_ - std::max<Index>(1, size_ / 10), count);
    constexpr double rounding = 1e-12;
    Index known = 0;
    while (known < most && squares[known] > rounding * squares[0])
        ++known;
    const RowMatrix weights = solver.eigenvectors().rowwise().reverse().leftCols(known) *
                              squares.head(known).cwiseSqrt().cwiseInverse().asDiagonal();
    RowMatrix& block = basis_.front();
    const double scale = 1.0 / std::sqrt(static_cast<double>(columns_));
    Random random(options_.seed);
    for (double& value : block.reshaped<Eigen::RowMajor>())
        value = scale * random.normal();
    for_strips(columns_, strip, [&](Index first, Index width) {
        RowMatrix part = RowMatrix::Zero(width, known);
        add_product_of_columns(sample.middleCols(first, width), weights, part);
        block.middleRows(first, width).leftCols(known) = part;
    });
    orthonormalise_columns(block, 0.0);
    product_ = RowMatrix::Zero(columns_, block.cols());
}

std::vector<std::span<double>> BlockKrylov::sums()
{
    std::vector<std::span<double>> arrays{{product_.data(), to_size(product_.size())}};
    if (passes_ == 0) {
        arrays.emplace_back(sums_.data(), to_size(sums_.size()));
        arrays.emplace_back(&squares_, 1);
    }
    return arrays;
}

void BlockKrylov::add(Index first, const RowMatrix& rows)
{
    if (mean_.size() == 0)
        mean_ = rows.colwise().mean().transpose();
    for (Index row = 0; row < rows.rows();) {
        const Index count = std::min(rows.rows() - row, held_.rows() - held_count_);
        hold(rows, row, count);
        for (Index i = 0; i < count; ++i)
            held_numbers_.push_back(first + row + i);
        row += count;
        if (held_count_ == held_.rows())
            flush();
    }
}

/// Centres rows, and puts them behind those that wait.
void BlockKrylov::hold(const RowMatrix& rows, Index first, Index count)
{
    for_strips(columns_, strip, [&](Index column, Index width) {
        const auto mean = mean_.segment(column, width).transpose();
        for (Index i = 0; i < count; ++i) {
            auto centred = held_.row(held_count_ + i).segment(column, width);
            centred = rows.row(first + i).segment(column, width) - mean;
            if (passes_ == 0)
                sums_.segment(column, width) += centred.transpose();
        }
    });
    held_count_ += count;
}

void BlockKrylov::flush()
{
    const RowMatrix& q = basis_.back();
    const auto rows = held_.topRows(held_count_);
    const RowMatrix y = sum_of_strips(
        columns_, rows.rows(), q.cols(), [&](Index first, Index count, RowMatrix& sum) {
            add_product(rows.middleCols(first, count), q.middleRows(first, count), sum);
        });
    std::vector<double> squares(to_size((columns_ + strip - 1) / strip), 0.0);
    for_strips(columns_, strip, [&](Index first, Index count) {
        add_product_of_columns(rows.middleCols(first, count), y, product_.middleRows(first, count));
        if (passes_ == 0)
            squares[to_size(first / strip)] = rows.middleCols(first, count).squaredNorm();
    });
    for (const double square : squares)
        squares_ += square;
    if (passes_ == 0)
        measure_residuals(y);
    held_count_ = 0;
    held_numbers_.clear();
}

/// Of the rows that wait: what is left without their shares in the start.
void BlockKrylov::measure_residuals(const RowMatrix& shares)
{
    if (residuals_.size() == 0)
        residuals_ = Eigen::VectorXd::Zero(rows_);
    const RowMatrix squares =
        sum_of_strips(columns_, held_count_, 1, [&](Index first, Index count, RowMatrix& sum) {
            sum += held_.topRows(held_count_).middleCols(first, count).rowwise().squaredNorm();
        });
    for (Index i = 0; i < held_count_; ++i)
        residuals_[held_numbers_[to_size(i)]] =
            std::max(0.0, squares(i, 0) - shares.row(i).squaredNorm());
}

std::span<double> BlockKrylov::residuals()
{
    return {residuals_.data(), to_size(residuals_.size())};
}

std::vector<Index> BlockKrylov::outlying_rows() const
{
    std::vector<double> sorted(residuals_.begin(), residuals_.end());
    const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
    std::nth_element(sorted.begin(), middle, sorted.end());
    // Twice the distance: of rows of many dimensions, which lie about as far as each other, there are none.
    const double usual = 4.0 * *middle;
    std::vector<Index> rows;
    for (Index i = 0; i < residuals_.size(); ++i)
        if (residuals_[i] > usual && residuals_[i] > 1e-12 * squares_)
            rows.push_back(i);
    std::stable_sort(rows.begin(), rows.end(),
                     [&](Index a, Index b) { return residuals_[a] > residuals_[b]; });
    rows.resize(std::min(rows.size(), to_size(size_)));
    return rows;
}

void BlockKrylov::add_directions(RowMatrix rows)
{
    RowMatrix block(columns_, rows.rows());
    for_strips(columns_, strip, [&](Index first, Index count) {
        block.middleRows(first, count) =
            rows.middleCols(first, count).transpose().colwise() - mean_.segment(first, count);
    });
    rows.resize(0, 0);
    const double length = block.colwise().norm().maxCoeff();
    RowMatrix ignored = RowMatrix::Zero(projected_.rows() + basis_.back().cols(), block.cols());
    orthogonalise(block, ignored);
    orthonormalise_columns(block, 1e-10 * length);
    if (block.cols() == 0)
        return;
    const Index most =
        std::max<Index>(1, size_ / 4); // so much more memory the following blocks take
    if (block.cols() > most)
        block = block.rightCols(most).eval();                // the largest: norms ascend
    ignored = RowMatrix::Zero(ignored.rows(), block.cols()); // once more, for what rounding left
    orthogonalise(block, ignored);
    orthonormalise_columns(block, 0.0);
    RowMatrix& last = basis_.back();
    RowMatrix both(columns_, last.cols() + block.cols());
    both << last, block;
    last = std::move(both);
    product_ = RowMatrix::Zero(columns_, last.cols());
}

/// Takes from a block what lies in the basis, twice, for rounding.
/// @param projected  Gets what was taken.
void BlockKrylov::orthogonalise(RowMatrix& block, RowMatrix& projected) const
{
    for (int round = 0; round < 2; ++round) {
        Index row = 0;
        for (const RowMatrix& part : basis_) {
            const RowMatrix shares = inner(part, block);
            subtract_product(block, part, shares);
            projected.middleRows(row, part.cols()) += shares;
            row += part.cols();
        }
    }
}

void BlockKrylov::end_pass()
{
    flush();
    const auto count = static_cast<double>(rows_);
    if (passes_++ == 0) { // the rows were taken about another point than their mean
        const Eigen::VectorXd offset = sums_ / count;
        const RowMatrix shares = offset.transpose() * basis_.back();
        for_strips(columns_, strip, [&](Index first, Index n) {
            product_.middleRows(first, n) -= count * offset.segment(first, n) * shares;
        });
        mean_ += offset;
        squares_ -= count * offset.squaredNorm();
    }
    const Index before = projected_.rows();
    const Index last = basis_.back().cols();
    RowMatrix column = RowMatrix::Zero(before + last, last);
    orthogonalise(product_, column);
    projected_.conservativeResize(before + last, before + last);
    projected_.rightCols(last) = column;
    projected_.bottomRows(last) = column.transpose();
    projected_.bottomRightCorner(last, last) =
        0.5 * (column.bottomRows(last) + column.bottomRows(last).transpose());

    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver{Eigen::MatrixXd(projected_)};
    if (solver.info() != Eigen::Success)
        throw NumericalError("principal components: the decomposition of the basis failed");
    const Eigen::VectorXd values = solver.eigenvalues().reverse();
    const Eigen::MatrixXd vectors = solver.eigenvectors().rowwise().reverse();

    const RowMatrix r = orthonormalise_columns(product_, 1e-13 * values[0]);
    if (r.rows() > 0) { // once more, for what rounding left
        RowMatrix ignored = RowMatrix::Zero(before + last, product_.cols());
        orthogonalise(product_, ignored);
        orthonormalise_columns(product_, 0.0);
    }
    judge(values, (r * vectors.bottomRows(last)).colwise().norm().transpose());
    ritz_vectors_ = vectors.leftCols(is_complete_ ? wanted_ : std::min(vectors.cols(), size_));
    if (is_complete_) {
        held_ = RowMatrix();
        return;
    }
    if (static_cast<Index>(basis_.size()) >= most_blocks_)
        restart(ritz_vectors_, values);
    basis_.push_back(std::move(product_));
    product_ = RowMatrix::Zero(columns_, basis_.back().cols());
}

/// Finds the number of components, estimates their errors, and decides whether they are good enough.
void BlockKrylov::judge(const Eigen::VectorXd& values, const Eigen::VectorXd& residuals)
{
    const Index found = values.size();
    wanted_ = options_.components;
    if (wanted_ == 0) {
        double sum = 0.0;
        while (wanted_ < found && sum < options_.variance * squares_)
            sum += std::max(values[wanted_++], 0.0);
        if (sum < options_.variance * squares_ && product_.cols() > 0) {
            error_ = 1.0;
            if (static_cast<Index>(basis_.size()) >= most_blocks_)
                throw LimitExceeded(join("a share of ", options_.variance,
                                         " of the variance needs more "
                                         "than ",
                                         found,
                                         " modes, which is what the memory holds; "
                                         "choose a number of modes or allow more memory"));
            return;
        }
    }
    wanted_ = std::min(wanted_, found);
    error_ = product_.cols() == 0 ? 0.0 : std::numeric_limits<double>::infinity();
    if (error_ > 0.0 && found > wanted_) {
        std::vector<double> least(to_size(wanted_), std::numeric_limits<double>::infinity());
        double squares = 0.0;
        for (Index m = 0; m + 1 < found; ++m) {
            squares += residuals[m] * residuals[m];
            const double gap = values[m] - values[m + 1];
            const double bound =
                gap > 0.0 ? squares / gap : std::numeric_limits<double>::infinity();
            for (Index k = 0; k <= std::min(m, wanted_ - 1); ++k)
                least[to_size(k)] = std::min({least[to_size(k)], residuals[k], bound});
        }
        error_ = 0.0;
        for (Index k = 0; k < wanted_; ++k)
            error_ = std::max(error_, least[to_size(k)] / std::abs(values[k]));
    }
    // After the first pass the rows that lie far from the start are still to join it.
    is_complete_ = error_ <= options_.tolerance && (passes_ > 1 || product_.cols() == 0);
    error_ = std::max(error_, rounding_of(values.head(wanted_)));
}

/// Keeps the best s Ritz vectors alone.
void BlockKrylov::restart(const Eigen::MatrixXd& vectors, const Eigen::VectorXd& values)
{
    const RowMatrix weights = vectors;
    RowMatrix kept(columns_, weights.cols());
    for_strips(columns_, strip, [&](Index first, Index count) {
        kept.middleRows(first, count).setZero();
        Index row = 0;
        for (const RowMatrix& part : basis_) {
            add_product(part.middleRows(first, count), weights.middleRows(row, part.cols()),
                        kept.middleRows(first, count));
            row += part.cols();
        }
    });
    basis_.clear();
    basis_.push_back(std::move(kept));
    projected_ = Eigen::MatrixXd(values.head(weights.cols()).asDiagonal());
}

RowMatrix BlockKrylov::components() const
{
    const RowMatrix weights = ritz_vectors_.leftCols(wanted_);
    RowMatrix result(wanted_, columns_);
    for_strips(columns_, strip, [&](Index first, Index count) {
        RowMatrix part = RowMatrix::Zero(count, wanted_);
        Index row = 0;
        for (const RowMatrix& block : basis_) {
            add_product(block.middleRows(first, count), weights.middleRows(row, block.cols()),
                        part);
            row += block.cols();
        }
        result.middleCols(first, count) = part.transpose();
    });
    return result;
}

void BlockKrylov::release(PassState& state)
{
    for (const Index number :
         {static_cast<Index>(passes_), static_cast<Index>(basis_.size()), projected_.rows()})
        state.numbers.push_back(number);
    state.arrays.emplace_back(mean_.transpose());
    state.arrays.emplace_back(RowMatrix::Constant(1, 1, squares_));
    state.arrays.push_back(projected_);
    for (RowMatrix& block : basis_) {
        state.numbers.push_back(block.cols());
        state.arrays.push_back(std::move(block));
    }
}

void BlockKrylov::restore(PassStateReader& state)
{
    passes_ = static_cast<int>(state.number());
    const auto blocks = state.number();
    const auto projected = static_cast<Index>(state.number());
    mean_ = state.vector(columns_);
    squares_ = state.vector(1)[0];
    projected_ = state.array(projected, projected);
    basis_.clear();
    for (std::int64_t b = 0; b < blocks; ++b)
        basis_.push_back(state.array(columns_, static_cast<Index>(state.number())));
    product_ = RowMatrix::Zero(columns_, basis_.back().cols());
}

} // namespace shape::internal
