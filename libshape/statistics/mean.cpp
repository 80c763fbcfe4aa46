// SPDX-License-Identifier: MIT

#include "libshape/statistics/mean.h"

#include "libshape/base/error.h"

namespace shape {

Eigen::VectorXd mean_of_rows(const RowMatrix& data)
{
    if (data.rows() == 0)
        throw InvalidInput("the mean of 0 rows does not exist");
    return data.colwise().mean().transpose();
}

} // namespace shape
