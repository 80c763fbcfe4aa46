// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <cstddef>

namespace shape::internal {

/// Vectors in single precision, one a column, each in a register of its own: 4 by #V, the last row 0.
using LaneVectors = Eigen::Matrix<float, 4, Eigen::Dynamic>;

/// One of them.
using Lanes = float __attribute__((vector_size(16)));

[[nodiscard]] inline Lanes* lanes(LaneVectors& vectors)
{
    return reinterpret_cast<Lanes*>(vectors.data());
}
[[nodiscard]] inline const Lanes* lanes(const LaneVectors& vectors)
{
    return reinterpret_cast<const Lanes*>(vectors.data());
}

/// The sum of a vector's entries; vectors are added up this many at a time in float, longer sums in
/// double.
inline constexpr std::size_t short_sum = 256;
[[nodiscard]] inline double lane_sum(const Lanes& a)
{
    return static_cast<double>(a[0]) + static_cast<double>(a[1]) + static_cast<double>(a[2]);
}

/// to = scale * rows, which are rows of three, one after the other.
inline void to_lanes(const double* rows, Eigen::Index count, double scale, LaneVectors& to)
{
    to.resize(4, count);
    to.topRows<3>() = (scale * Eigen::Matrix3Xd::Map(rows, 3, count)).cast<float>();
    to.row(3).setZero();
}

} // namespace shape::internal
