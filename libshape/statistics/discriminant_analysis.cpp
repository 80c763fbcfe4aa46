// SPDX-License-Identifier: MIT

#include "libshape/statistics/discriminant_analysis.h"

#include <Eigen/Cholesky>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/statistics/mean.h"
#include "libshape/statistics/regular_coordinates.h"

namespace shape {
using namespace internal;
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

void check(const RowMatrix& points, const Grouping& groups)
{
    if (groups.size() != points.rows() || points.cols() == 0)
        throw InvalidInput(join("discriminants: points are ", points.rows(), " by ", points.cols(),
                                ", groups of ", groups.size(),
                                "; rows must agree and columns be at least 1"));
    if (groups.group_count() < 2)
        throw InvalidInput("discriminants: all points are in one group; at least two are needed");
    if (points.rows() < points.cols() + groups.group_count())
        throw InvalidInput(join("discriminants: ", points.rows(), " points of ", points.cols(),
                                " coordinates in ", groups.group_count(), " groups; at least ",
                                points.cols() + groups.group_count(), " are needed"));
    if (!points.allFinite())
        throw InvalidInput("discriminants: a coordinate is not finite");
}

/// Makes the entry of largest magnitude of every row positive.
void fix_signs(RowMatrix& rows)
{
    for (Index k = 0; k < rows.rows(); ++k) {
        Index largest = 0;
        rows.row(k).cwiseAbs().maxCoeff(&largest);
        if (rows(k, largest) < 0.0)
            rows.row(k) *= -1.0;
    }
}

} // namespace

DiscriminantAnalysis discriminant_analysis(const RowMatrix& points, const Grouping& groups)
{
    check(points, groups);
    const Index group_count = groups.group_count();
    const MatrixXd indicator = indicators(groups);
    const Eigen::VectorXd counts = indicator.colwise().sum().transpose();
    DiscriminantAnalysis result;
    result.mean = mean_of_rows(points);
    result.log_priors = (counts / static_cast<double>(points.rows())).array().log();

    const RowMatrix centred = points.rowwise() - result.mean.transpose();
    const MatrixXd means = counts.cwiseInverse().asDiagonal() * (indicator.transpose() * centred);
    const MatrixXd within = centred - indicator * means;
    const Eigen::VectorXd spread = within.colwise().norm().transpose();
    const MatrixXd scaled = within * spread.cwiseInverse().asDiagonal();
    const Eigen::LLT<MatrixXd> factor(scaled.transpose() * scaled);
    if (regular_coordinates(points, groups) < points.cols() || factor.info() != Eigen::Success)
        throw NumericalError(
            "discriminants: the pooled covariance of the groups is singular; use fewer "
            "coordinates");

    // Rows times `whitening` have the pooled covariance 1.
    const double degrees = static_cast<double>(points.rows() - group_count);
    const MatrixXd whitening =
        std::sqrt(degrees) * spread.cwiseInverse().asDiagonal() *
        MatrixXd(factor.matrixL().solve(MatrixXd::Identity(points.cols(), points.cols())))
            .transpose();
    const MatrixXd white = counts.cwiseSqrt().asDiagonal() * (means * whitening);
    const Eigen::JacobiSVD<MatrixXd> svd(white, Eigen::ComputeThinV);
    const Index count = std::min(points.cols(), group_count - 1);
    result.axes = (whitening * svd.matrixV().leftCols(count)).transpose();
    fix_signs(result.axes);
    result.ratios =
        svd.singularValues().head(count).cwiseAbs2() / static_cast<double>(group_count - 1);
    result.group_means = means * result.axes.transpose();
    return result;
}

RowMatrix canonical_variates(const DiscriminantAnalysis& analysis, const RowMatrix& points)
{
    if (points.cols() != analysis.mean.size())
        throw InvalidInput(join("canonical variates: points have ", points.cols(),
                                " coordinates, must have ", analysis.mean.size()));
    return (points.rowwise() - analysis.mean.transpose()) * analysis.axes.transpose();
}

std::vector<int> classify(const DiscriminantAnalysis& analysis, const RowMatrix& points)
{
    // Directions that tell no group means apart cancel in the comparison: canonical variates do.
    const RowMatrix variates = canonical_variates(analysis, points);
    std::vector<int> groups;
    for (Index i = 0; i < variates.rows(); ++i) {
        const Eigen::VectorXd cost =
            0.5 * (analysis.group_means.rowwise() - variates.row(i)).rowwise().squaredNorm() -
            analysis.log_priors;
        Index nearest = 0;
        cost.minCoeff(&nearest);
        groups.push_back(static_cast<int>(nearest));
    }
    return groups;
}

} // namespace shape
