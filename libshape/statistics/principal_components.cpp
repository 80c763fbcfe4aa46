// SPDX-License-Identifier: MIT

#include "libshape/statistics/principal_components.h"

#include <Eigen/Cholesky>
#include <Eigen/Jacobi>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/require.h"
#include "libshape/base/threads.h"
#include "libshape/base/to_size.h"
#include "libshape/linalg/symmetric_eigen.h"
#include "libshape/statistics/inner_products.h"
#include "libshape/statistics/mean.h"

namespace shape {
using namespace internal;
namespace {

using Eigen::Index;

constexpr double smallest_variance_ratio =
    1e-12; ///< Modes of less, relative to the first one, are rounding.

void check_data(const RowMatrix& data, const PrincipalComponentsOptions& options)
{
    if (data.rows() < 2 || data.cols() == 0)
        throw InvalidInput(join("principal components: the data has ", data.rows(),
                                " observations of ", data.cols(),
                                " variables, must have at least 2 of at least 1"));
    if (!data.allFinite())
        throw InvalidInput("principal components: the data has an entry that is not finite");
    if (options.modes > data.rows() - 1)
        throw InvalidInput(join("principal components: modes is ", options.modes,
                                ", must be in [0, ", data.rows() - 1, "] for ", data.rows(),
                                " observations"));
}

/// weights^T x, in fixed strips of columns.
RowMatrix combine_rows(const RowMatrix& weights, const RowMatrix& x)
{
    RowMatrix combined(weights.cols(), x.cols());
    parallel_for(to_size(x.cols()), 512, [&](std::size_t begin, std::size_t end) {
        const auto first = static_cast<Index>(begin);
        const auto count = static_cast<Index>(end - begin);
        combined.middleCols(first, count).noalias() =
            weights.transpose() * x.middleCols(first, count);
    });
    return combined;
}

/// x = weights^T x in place, in the same strips: the modes may be as large as the data.
void mix_rows(const RowMatrix& weights, RowMatrix& x)
{
    parallel_for(to_size(x.cols()), 512, [&](std::size_t begin, std::size_t end) {
        auto strip = x.middleCols(static_cast<Index>(begin), static_cast<Index>(end - begin));
        strip = (weights.transpose() * strip).eval();
    });
}

/// x modes^T, in fixed strips of rows.
RowMatrix coordinates(const RowMatrix& x, const RowMatrix& modes)
{
    RowMatrix scores(x.rows(), modes.rows());
    parallel_for(to_size(x.rows()), 32, [&](std::size_t begin, std::size_t end) {
        const auto first = static_cast<Index>(begin);
        const auto count = static_cast<Index>(end - begin);
        scores.middleRows(first, count).noalias() = x.middleRows(first, count) * modes.transpose();
    });
    return scores;
}

/// Eigenpairs of the Gram matrix for the modes that are asked for and are more than rounding.
Eigenpairs leading_eigenpairs(const Eigen::MatrixXd& gram,
                              const PrincipalComponentsOptions& options)
{
    const int most = static_cast<int>(gram.rows()) - 1;
    const double wanted = options.variance * gram.trace();
    int count = options.modes > 0        ? options.modes
                : options.variance < 1.0 ? std::min(most, 32)
                                         : most;
    Eigenpairs pairs = largest_eigenpairs(gram, count);
    while (options.modes == 0 && count < most && pairs.values.sum() < wanted) {
        count = std::min(most, 4 * count);
        pairs = largest_eigenpairs(gram, count);
    }
    Index kept = 0;
    double sum = 0.0;
    while (kept < count && pairs.values[kept] > smallest_variance_ratio * pairs.values[0] &&
           (options.modes > 0 || options.variance == 1.0 || sum < wanted))
        sum += pairs.values[kept++];
    return {pairs.values.head(kept), pairs.vectors.leftCols(kept)};
}

/// Makes the rows of modes = weights^T x, which are nearly so, orthonormal to rounding. With
/// modes modes^T = L L^T, applying L^-1 is the Gram-Schmidt process in the order of the rows.
void orthonormalise(RowMatrix& modes, RowMatrix& weights)
{
    const Eigen::LLT<Eigen::MatrixXd> factor(inner_products(modes));
    if (factor.info() != Eigen::Success)
        throw NumericalError("principal components: the modes are not linearly independent");
    const RowMatrix change =
        factor.matrixL().solve(Eigen::MatrixXd::Identity(modes.rows(), modes.rows()));
    mix_rows(change.transpose(), modes);
    weights = weights * change.transpose();
}

/// The rotation J that makes the columns of scores J orthogonal (one-sided Jacobi). The Gram matrix
/// knows a mode only up to rounding of the largest variance; the scores know it better.
RowMatrix decorrelating_rotation(Eigen::MatrixXd scores)
{
    const Index count = scores.cols();
    RowMatrix rotation = RowMatrix::Identity(count, count);
    Eigen::VectorXd squares = scores.colwise().squaredNorm();
    constexpr int most_sweeps = 20; // one or two suffice from nearly orthogonal columns
    bool rotated = true;
    for (int sweep = 0; rotated && sweep < most_sweeps; ++sweep) {
        rotated = false;
        for (Index j = 0; j < count; ++j)
            for (Index k = j + 1; k < count; ++k) {
                const double product = scores.col(j).dot(scores.col(k));
                if (std::abs(product) <= 1e-13 * std::sqrt(squares[j] * squares[k]))
                    continue;
                Eigen::JacobiRotation<double> turn;
                turn.makeJacobi(squares[j], product, squares[k]);
                scores.applyOnTheRight(j, k, turn);
                rotation.applyOnTheRight(j, k, turn);
                squares[j] = scores.col(j).squaredNorm();
                squares[k] = scores.col(k).squaredNorm();
                rotated = true;
            }
    }
    return rotation;
}

/// Makes the entry of largest magnitude of every mode positive.
void fix_signs(RowMatrix& modes, RowMatrix& weights)
{
    for (Index k = 0; k < modes.rows(); ++k) {
        Index largest = 0;
        modes.row(k).cwiseAbs().maxCoeff(&largest);
        if (modes(k, largest) < 0.0) {
            modes.row(k) *= -1.0;
            weights.col(k) *= -1.0;
        }
    }
}

/// Variances of the scores. Modes of equal variance may have changed places by rounding: they are
/// put in descending order.
void measure_variances(PrincipalComponents& components)
{
    const auto divisor = static_cast<double>(components.scores.rows() - 1);
    const Eigen::VectorXd variances =
        components.scores.colwise().squaredNorm().transpose() / divisor;
    std::vector<Index> order(to_size(variances.size()));
    std::iota(order.begin(), order.end(), 0);
    std::stable_sort(order.begin(), order.end(),
                     [&](Index a, Index b) { return variances[a] > variances[b]; });
    components.variances = variances(order);
    if (!std::is_sorted(order.begin(), order.end())) {
        components.modes = RowMatrix(components.modes(order, Eigen::all));
        components.weights = RowMatrix(components.weights(Eigen::all, order));
        components.scores = RowMatrix(components.scores(Eigen::all, order));
    }
}

} // namespace

void check(const PrincipalComponentsOptions& options)
{
    require_at_least(0, options.modes, "PrincipalComponentsOptions.modes");
    require(options.variance > 0.0 && options.variance <= 1.0,
            "PrincipalComponentsOptions.variance", options.variance, "in (0, 1]");
    require(options.modes == 0 || options.variance == 1.0, "PrincipalComponentsOptions.variance",
            options.variance, "1 where modes, too, says how many are kept");
}

PrincipalComponents principal_components(RowMatrix data, const PrincipalComponentsOptions& options)
{
    check(options);
    check_data(data, options);
    PrincipalComponents result;
    result.mean = mean_of_rows(data);
    const double squares = data.squaredNorm();
    data.rowwise() -= result.mean.transpose();
    const RowMatrix& centred = data;
    { // what is N by N goes before the modes come
        const Eigen::MatrixXd gram = inner_products(centred);
        if (gram.trace() <= 1e-24 * squares)
            throw InvalidInput(join("principal components: all ", data.rows(),
                                    " observations are equal, they have no modes"));
        result.total_variance = gram.trace() / static_cast<double>(data.rows() - 1);
        const Eigenpairs pairs = leading_eigenpairs(gram, options);
        result.weights = pairs.vectors * pairs.values.cwiseSqrt().cwiseInverse().asDiagonal();
    }
    result.modes = combine_rows(result.weights, centred);
    orthonormalise(result.modes, result.weights);
    const RowMatrix rotation = decorrelating_rotation(coordinates(centred, result.modes));
    mix_rows(rotation, result.modes);
    result.weights = result.weights * rotation;
    fix_signs(result.modes, result.weights);
    result.scores = coordinates(centred, result.modes);
    measure_variances(result);
    return result;
}

RowMatrix companion_modes(const PrincipalComponents& components, RowMatrix companion)
{
    if (companion.rows() != components.weights.rows())
        throw InvalidInput(join("companion has ", companion.rows(), " rows, the components have ",
                                components.weights.rows(), " observations"));
    // The weights of a mode sum to 0 up to rounding: centring keeps that rounding small.
    companion.rowwise() -= mean_of_rows(companion).transpose();
    return combine_rows(components.weights, companion);
}

} // namespace shape
