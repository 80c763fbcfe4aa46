// SPDX-License-Identifier: MIT

#include "libshape/statistics/distance_matrix.h"

#include <limits>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/threads.h"
#include "libshape/base/to_size.h"

namespace shape {
using namespace internal;

Eigen::MatrixXd distance_matrix(const RowMatrix& data)
{
    if (!data.allFinite())
        throw InvalidInput("distances: the data has an entry that is not finite");
    Eigen::MatrixXd distances = Eigen::MatrixXd::Zero(data.rows(), data.rows());
    parallel_for(to_size(data.rows()), 1, [&](std::size_t row, std::size_t) {
        const auto i = static_cast<Eigen::Index>(row);
        for (Eigen::Index j = 0; j < i; ++j)
            distances(i, j) = (data.row(i) - data.row(j)).norm();
    });
    return distances.selfadjointView<Eigen::Lower>();
}

void check_distances(const Eigen::MatrixXd& distances)
{
    if (distances.rows() != distances.cols() || distances.rows() == 0)
        throw InvalidInput(join("distances: the matrix is ", distances.rows(), " by ",
                                distances.cols(), ", must be square and not empty"));
    for (Eigen::Index i = 0; i < distances.rows(); ++i)
        for (Eigen::Index j = 0; j <= i; ++j) {
            const double d = distances(i, j);
            if (!(d >= 0.0 && d <= std::numeric_limits<double>::max()) || d != distances(j, i) ||
                (i == j && d != 0.0))
                throw InvalidInput(join("distances: (", i, ", ", j, ") is ", d, " and (", j, ", ",
                                        i, ") is ", distances(j, i),
                                        "; a distance is finite, >= 0, the same both ways and 0 "
                                        "from a thing to itself"));
        }
}

} // namespace shape
