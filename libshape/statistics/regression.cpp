// SPDX-License-Identifier: MIT

#include "libshape/statistics/regression.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/statistics/mean.h"

namespace shape {
using namespace internal;
namespace {

using Eigen::Index;

void check(const RowMatrix& data, const Eigen::MatrixXd& covariates)
{
    if (covariates.rows() != data.rows() || covariates.cols() < 1 || data.cols() < 1)
        throw InvalidInput(join("regression: the data is ", data.rows(), " by ", data.cols(),
                                ", the covariates ", covariates.rows(), " by ", covariates.cols(),
                                "; rows must agree and columns be at least 1"));
    if (data.rows() < covariates.cols() + 2)
        throw InvalidInput(join("regression: ", data.rows(), " observations on ", covariates.cols(),
                                " covariates; at least ", covariates.cols() + 2, " are needed"));
    if (!data.allFinite() || !covariates.allFinite())
        throw InvalidInput("regression: an entry is not finite");
    for (Index k = 0; k < covariates.cols(); ++k) {
        const double largest = covariates.col(k).cwiseAbs().maxCoeff();
        const double squares = covariates.col(k).squaredNorm();
        if (!std::isfinite(squares) ||
            (largest > 0.0 && squares < std::numeric_limits<double>::min()))
            throw InvalidInput(join("regression: covariate ", k, " is ", largest,
                                    " at most, and its squares overflow or underflow; take another "
                                    "unit"));
    }
}

/// The pseudo-inverse of centred covariates, transposed: N by C.
RowMatrix dual_basis(const Eigen::MatrixXd& centred)
{
    // Columns of equal length make the tolerance one of directions.
    const Eigen::RowVectorXd lengths = centred.colwise().norm();
    Eigen::MatrixXd scaled = centred;
    for (Index k = 0; k < scaled.cols(); ++k)
        scaled.col(k) /= lengths[k];
    Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(scaled);
    qr.setThreshold(1e-9); // far above rounding, far below what a covariate of its own leaves
    if (!lengths.allFinite() || !scaled.allFinite() || qr.rank() < scaled.cols())
        throw InvalidInput(
            "regression: a covariate is constant or a combination of the other covariates");
    const Index count = scaled.cols();
    const Eigen::MatrixXd thin_q =
        qr.householderQ() * Eigen::MatrixXd::Identity(scaled.rows(), count);
    const Eigen::MatrixXd upper = qr.matrixR().topLeftCorner(count, count);
    const Eigen::MatrixXd inverse = upper.triangularView<Eigen::Upper>().solve(thin_q.transpose());
    RowMatrix weights = (qr.colsPermutation() * inverse).transpose();
    for (Index k = 0; k < count; ++k)
        weights.col(k) /= lengths[k];
    return weights;
}

} // namespace

Regression regress(const RowMatrix& data, const Eigen::MatrixXd& covariates)
{
    check(data, covariates);
    Regression result;
    result.mean = mean_of_rows(data);
    result.covariate_means = covariates.colwise().mean().transpose();
    Eigen::MatrixXd centred = covariates.rowwise() - result.covariate_means.transpose();
    for (Index k = 0; k < centred.cols(); ++k)
        if (centred.col(k).norm() <= 1e-12 * covariates.col(k).norm())
            centred.col(k).setZero(); // constant but for rounding
    result.weights = dual_basis(centred);
    result.slopes = result.weights.transpose() * data;
    double explained = 0.0;
    double total = 0.0;
    for (Index i = 0; i < data.rows(); ++i) {
        explained += (centred.row(i) * result.slopes).squaredNorm();
        total += (data.row(i) - result.mean.transpose()).squaredNorm();
    }
    result.r_squared = total > 0.0 ? std::min(explained / total, 1.0) : 0.0;
    return result;
}

Eigen::VectorXd regression_scores(const Regression& regression, const RowMatrix& data,
                                  int covariate)
{
    if (covariate < 0 || covariate >= regression.slopes.rows() ||
        data.cols() != regression.mean.size())
        throw InvalidInput(join("regression scores: covariate ", covariate, " of ",
                                regression.slopes.rows(), ", data of ", data.cols(),
                                " variables, must have ", regression.mean.size()));
    const Eigen::VectorXd slope = regression.slopes.row(covariate).transpose();
    if (!(slope.squaredNorm() > 0.0))
        throw InvalidInput(join("regression scores: the slope of covariate ", covariate, " is 0"));
    const Eigen::VectorXd along = data * slope;
    return (along.array() - regression.mean.dot(slope)) / slope.squaredNorm() +
           regression.covariate_means[covariate];
}

} // namespace shape
