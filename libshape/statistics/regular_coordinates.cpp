// SPDX-License-Identifier: MIT

#include "libshape/statistics/regular_coordinates.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "libshape/statistics/mean.h"

namespace shape::internal {

Eigen::Index regular_coordinates(const RowMatrix& points, const Grouping& groups)
{
    const Eigen::MatrixXd indicator = indicators(groups);
    const Eigen::VectorXd counts = indicator.colwise().sum().transpose();
    const RowMatrix centred = points.rowwise() - mean_of_rows(points).transpose();
    const Eigen::MatrixXd means =
        counts.cwiseInverse().asDiagonal() * (indicator.transpose() * centred);
    Eigen::MatrixXd within = centred - indicator * means;
    Eigen::Index varying = 0; // those before the first that does not vary
    for (; varying < within.cols(); ++varying) {
        const double spread = within.col(varying).norm();
        if (!(spread > 1e-12 * centred.col(varying).norm()))
            break;
        within.col(varying) /= spread; // coordinates of unit spread: what is asked is of directions
    }
    if (varying == 0)
        return 0;
    const Eigen::HouseholderQR<Eigen::MatrixXd> factor(within.leftCols(varying));
    Eigen::Index regular = 0;
    // A diagonal entry is the sine of the angle between a direction and those before: below 1e-7 the square of it,
    // of which a factor of the covariance is made, is rounding.
    while (regular < std::min(varying, within.rows()) &&
           std::abs(factor.matrixQR()(regular, regular)) > 1e-7)
        ++regular;
    return regular;
}

} // namespace shape::internal
