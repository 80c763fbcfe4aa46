// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <cmath>

namespace shape::internal {

/// Makes the first of the entries of largest magnitude (but for rounding) positive.
inline void fix_sign(Eigen::Ref<Eigen::VectorXd> column)
{
    const double largest = column.cwiseAbs().maxCoeff();
    for (const double entry : column)
        if (std::abs(entry) >= (1.0 - 1e-9) * largest) {
            if (entry < 0.0)
                column *= -1.0;
            return;
        }
}

} // namespace shape::internal
