// SPDX-License-Identifier: MIT

#include "libshape/statistics/component_steps.h"

#include <Eigen/Cholesky>
#include <Eigen/Jacobi>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "libshape/base/error.h"
#include "libshape/base/to_size.h"
#include "libshape/linalg/strips.h"
#include "libshape/statistics/inner_products.h"

namespace shape::internal {

using Eigen::Index;

void mix_rows(const RowMatrix& weights, RowMatrix& x)
{
    for_strips(x.cols(), 512, [&](Index first, Index count) {
        auto strip = x.middleCols(first, count);
        strip = (weights.transpose() * strip).eval();
    });
}

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
                // Uncorrelated but for the rounding of a sum over some hundred or thousand scores.
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

} // namespace shape::internal
