// SPDX-License-Identifier: MIT

#include "libshape/statistics/classical_scaling.h"

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/linalg/symmetric_eigen.h"
#include "libshape/statistics/column_signs.h"
#include "libshape/statistics/distance_matrix.h"
#include "libshape/statistics/inner_products.h"

namespace shape {
using namespace internal;
ClassicalScaling classical_scaling(const Eigen::MatrixXd& distances, int dimensions)
{
    check_distances(distances);
    if (dimensions < 1 || dimensions > distances.rows())
        throw InvalidInput(join("classical scaling: dimensions is ", dimensions,
                                ", must be in [1, ", distances.rows(), "]"));
    const Eigen::MatrixXd products = inner_products_of_distances(distances);
    Eigenpairs pairs = largest_eigenpairs(products, dimensions);
    for (Eigen::Index k = 0; k < pairs.values.size(); ++k)
        fix_sign(pairs.vectors.col(k));
    return {pairs.vectors * pairs.values.cwiseMax(0.0).cwiseSqrt().asDiagonal(), pairs.values,
            products.trace()};
}

} // namespace shape
