// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Geometry>

#include "libshape/base/blocks.h"

namespace shape::internal {

/// The quaternions of a block, a row for each number.
struct QuaternionRows
{
    Row w, x, y, z;

    void set(int i, const Eigen::Quaterniond& from, double sign_of_vector = 1.0)
    {
        w[i] = from.w();
        x[i] = sign_of_vector * from.x();
        y[i] = sign_of_vector * from.y();
        z[i] = sign_of_vector * from.z();
    }
    [[nodiscard]] Eigen::Quaterniond get(int i) const { return {w[i], x[i], y[i], z[i]}; }
};

} // namespace shape::internal
