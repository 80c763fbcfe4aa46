// SPDX-License-Identifier: MIT

#include "libshape/linalg/added_rows.h"

#include <algorithm>

namespace shape::internal {

Eigen::VectorXd with_rows_added(Eigen::VectorXd base, const RowMatrix& rows,
                                const Eigen::VectorXd& weights)
{
    constexpr Eigen::Index piece = 1024; // which the first cache holds while rows are read
    for (Eigen::Index first = 0; first < base.size(); first += piece) {
        const Eigen::Index count = std::min(piece, base.size() - first);
        auto sum = base.segment(first, count);
        for (Eigen::Index k = 0; k < weights.size(); ++k)
            if (weights[k] != 0.0)
                sum += weights[k] * rows.row(k).segment(first, count).transpose();
    }
    return base;
}

} // namespace shape::internal
