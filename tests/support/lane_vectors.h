// SPDX-License-Identifier: MIT

#pragma once

#include "libshape/base/random.h"
#include "libshape/linalg/lanes.h"

namespace shape::test {
using namespace internal;

/// Entries uniform in [-1, 1).
[[nodiscard]] inline LaneVectors random_lane_vectors(Eigen::Index count, Random& random)
{
    LaneVectors vectors = LaneVectors::NullaryExpr(
        4, count, [&] { return static_cast<float>(random.uniform(-1.0, 1.0)); });
    vectors.row(3).setZero();
    return vectors;
}

/// Three numbers a vector, one vector after the other.
[[nodiscard]] inline Eigen::VectorXd flat(const LaneVectors& vectors)
{
    return vectors.topRows<3>().cast<double>().reshaped();
}

/// The same back.
[[nodiscard]] inline LaneVectors lane_vectors(const Eigen::VectorXd& flat_vectors)
{
    LaneVectors vectors;
    to_lanes(flat_vectors.data(), flat_vectors.size() / 3, 1.0, vectors);
    return vectors;
}

} // namespace shape::test
